#include "isofront/voxels/LevelEvaluation.h"

#include <isofront/core/Assert.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

// Based on: S. Jablonski and T. Martyn, "Real-time rendering of continuous levels of detail for
// sparse voxel octrees", sections 4 to 6.

namespace isofront::voxels {

double levelAtDistance(double distance, double offset, std::uint32_t coarsest)
{
    ISOFRONT_ASSERT(distance >= 0 && offset > 0, "levels need a distance between them");
    return std::min(distance / offset, static_cast<double>(coarsest));
}

std::optional<core::Error> FillRates::check() const
{
    constexpr double kApart = 6; // levels differ by four, and pattern nodes among them by some more
    if (std::isfinite(most) && std::isfinite(progression) && least > 0 && progression > 0 &&
        most >= kApart * least)
        return std::nullopt;
    return core::Error{
        core::ErrorCode::usage,
        "fill rates from " + std::to_string(least) + " to " + std::to_string(most) +
            " pixels with a progression of " + std::to_string(progression) +
            " can't decide on levels: all must be positive, and the most six times the least"};
}

double FillRates::threshold(std::uint32_t level) const
{
    double sum = 0;
    for (std::uint32_t i = 0; i <= level; ++i)
        sum = sum * progression + 1;
    return most * sum;
}

double FillRates::weight(double fill, std::uint32_t level) const
{
    return std::clamp(fill / threshold(level), 0.0, 1.0);
}

LevelStep stepOf(const FillRates& rates, double fill, std::uint32_t level)
{
    if (fill < rates.least)
        return LevelStep::coarser;
    return rates.weight(fill, level) >= 1 ? LevelStep::finer : LevelStep::stay;
}

double
approximateFill(const core::Box& bounds, double edge, const glm::dvec3& eye, double pixelsPerUnit)
{
    const glm::dvec3 away = bounds.centre() - eye;
    const double distance = std::max(glm::length(away), edge);
    // the outline of a cube seen along a unit vector has the sum of its components as area
    const glm::dvec3 size = glm::abs(away);
    const double shape = glm::length(away) > 0 ? (size.x + size.y + size.z) / glm::length(away) : 1;
    const double pixels = edge * pixelsPerUnit / distance;
    return shape * pixels * pixels;
}

std::optional<PatternNode> patternNode(std::span<const std::uint64_t> picture)
{
    // the least of depth and id together is what is wanted, whatever the order of pixels
    std::uint64_t nearest = kNoPatternPixel;
    for (const std::uint64_t pixel : picture)
        nearest = std::min(nearest, pixel);
    if (nearest == kNoPatternPixel)
        return std::nullopt;
    PatternNode node;
    node.id = static_cast<std::uint32_t>(nearest & 0xffffffffU);
    node.depth = static_cast<std::uint32_t>(nearest >> 32U);
    for (const std::uint64_t pixel : picture)
        if (pixel != kNoPatternPixel && (pixel & 0xffffffffU) == node.id)
            ++node.pixels;
    return node;
}

double fillOf(const PatternNode& node, double approximate)
{
    return std::max(static_cast<double>(node.pixels), approximate);
}

std::uint32_t calibratedLevel(std::span<const double> fills, double least)
{
    std::optional<std::size_t> best;
    for (std::size_t level = 0; level < fills.size(); ++level)
        if (fills[level] > 0 && fills[level] >= least && (!best || fills[level] < fills[*best]))
            best = level;
    const std::size_t coarsest = fills.empty() ? 0 : fills.size() - 1;
    return static_cast<std::uint32_t>(best.value_or(coarsest));
}

core::Result<LevelControl> LevelControl::create(
    const LevelControlSettings& settings, std::uint32_t coarsest, std::uint32_t start)
{
    if (auto error = settings.rates.check())
        return tl::unexpected(std::move(*error));
    if (settings.framesToAgree < 1 || settings.framesOfLevel < 1 || start > coarsest)
        return core::failure(
            core::ErrorCode::usage,
            "level " + std::to_string(start) + " of " + std::to_string(coarsest) +
                " can't be begun with: frames are counted from one, and levels to the coarsest");
    return LevelControl(settings, coarsest, start);
}

LevelControl::LevelControl(
    const LevelControlSettings& settings, std::uint32_t coarsest, std::uint32_t start)
    : _settings(settings), _coarsest(coarsest), _level(start), _number(start)
{
}

double LevelControl::weightOf(double fill) const
{
    if (_level == 0)
        return 0; // there is nothing finer
    // what this level's pattern node fills when the level is taken over from the next coarser one;
    // for large progressions that may be more than it takes to leave it
    const double highest = _settings.rates.threshold(_level);
    const double lowest = std::min(_settings.rates.threshold(_level + 1) / 4, highest / 2);
    return std::clamp((fill - lowest) / (highest - lowest), 0.0, 1.0);
}

ShownLevel LevelControl::update(const LevelObservation& observation)
{
    const bool isKnown = observation.fill > 0 && std::isfinite(observation.fill);
    const bool isTiny = observation.pixels > 0 && observation.pixels <= _settings.fewestPixels;
    if (!isKnown || isTiny)
        return shown();
    // as if the node were of the level decided on
    const int coarser = static_cast<int>(_level) - static_cast<int>(observation.level);
    double fill = std::ldexp(observation.fill, 2 * coarser);
    const bool isAllShown = observation.pixels > 0 && observation.voxels >= observation.pixels;

    LevelStep step = stepOf(_settings.rates, fill, _level);
    if ((step == LevelStep::finer && (_level == 0 || isAllShown)) ||
        (step == LevelStep::coarser && _level == _coarsest))
        step = LevelStep::stay;
    _wished = step == _wish ? _wished + 1 : 1;
    _wish = step;
    if (step != LevelStep::stay && _wished >= _settings.framesToAgree) {
        _wish = LevelStep::stay;
        _wished = 0;
        if (step == LevelStep::finer)
            --_level;
        else
            ++_level;
        fill = std::ldexp(fill, step == LevelStep::finer ? -2 : 2);
    }

    double target = static_cast<double>(_level) - weightOf(fill);
    if (isAllShown)
        target = std::max(target, _number);
    const double most = 1.0 / _settings.framesOfLevel;
    _number += std::clamp(target - _number, -most, most);
    return shown();
}

ShownLevel LevelControl::shown() const
{
    const double level = std::ceil(_number);
    return {static_cast<std::uint32_t>(level), level - _number};
}

} // namespace isofront::voxels
