#pragma once

#include <isofront/core/Image.h>

#include <span>

namespace isofront::exchange {

/// A copy of another size. Each new pixel is the mean of the area that it covers, taken in linear
/// light and weighted by opacity, so that fine detail neither flickers nor darkens.
///
/// @param width, height  [px] at least 1 (asserted), as is the image's own size
core::Image resampled(const core::Image& image, int width, int height);

/// Pictures side by side, from the top left, row by row, with thin dark margins between them.
///
/// The first picture's shape makes the shape of every place; others are fitted into it whole.
///
/// @param columns         at least 1 (asserted); fewer are used if there are fewer pictures
/// @param thumbnailWidth  [px] at least 1 (asserted)
/// @return an image without pixels if there are no pictures
core::Image contactSheet(std::span<const core::Image> images, int columns, int thumbnailWidth);

} // namespace isofront::exchange
