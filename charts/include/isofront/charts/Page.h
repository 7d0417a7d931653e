#pragma once

#include <string>

namespace isofront::charts {

/// The beginning of a page for people, up to and with `<main>`: one file in light and dark colours,
/// without scripts, that asks the network for nothing. Classes of its style sheet: `what`, `tiles`
/// with `tile`, `legend`, `wide` and `narrow` (a picture for each width of screen), `scroll`,
/// `settings`; `section` and `table` need none. Curves have the classes `a` to `h`.
/// @param title  plain text
std::string pageBegin(const std::string& title);

/// What closes the page.
std::string pageEnd();

/// The colours and strokes of the charts alone, for an SVG file of its own.
std::string chartStyle();

/// The class of the curve with this number; they repeat after eight.
std::string curveStyle(unsigned number);

} // namespace isofront::charts
