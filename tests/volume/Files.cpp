#include "volume/Files.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isofront::test {

std::string zlibbed(const std::string& bytes)
{
    return tests::deflated(bytes);
}

std::string nrrdHeader(
    const std::string& type,
    const std::string& sizes,
    const std::string& encoding,
    const std::string& extra)
{
    const auto axes = 1 + std::count(sizes.begin(), sizes.end(), ' ');
    return "NRRD0004\n# made by a test\ntype: " + type + "\ndimension: " + std::to_string(axes) +
           "\nsizes: " + sizes + "\nencoding: " + encoding + "\nendian: little\n" + extra + "\n";
}

std::string metaHeader(const std::string& sizes, const std::string& extra, const std::string& data)
{
    return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
           "Offset = 5 6 7\nElementSpacing = 2 3 4\nTransformMatrix = 0 1 0 -1 0 0 0 0 1\nDimSize "
           "= " +
           sizes + "\nElementType = MET_UCHAR\n" + extra + "ElementDataFile = " + data + "\n";
}

std::string niftiHeader(const NiftiOptions& options)
{
    std::string bytes(352, '\0');
    const auto put = [&](std::size_t offset, auto value) {
        std::memcpy(bytes.data() + offset, &value, sizeof value);
    };
    put(0, std::int32_t{348});
    put(40, static_cast<std::int16_t>(options.dimensions.size()));
    for (std::size_t axis = 0; axis < 7; ++axis)
        put(42 + 2 * axis,
            axis < options.dimensions.size() ? options.dimensions[axis] : std::int16_t{1});
    put(70, options.type);
    put(72, options.bits);
    put(76, 1.0F);
    for (std::size_t axis = 0; axis < 3; ++axis)
        put(80 + 4 * axis, options.spacing[axis]);
    put(108, options.offset);
    put(112, options.slope);
    put(116, options.intercept);
    put(254, std::int16_t{1}); // the sform holds scanner coordinates
    for (std::size_t i = 0; i < 12; ++i)
        put(280 + 4 * i, options.affine[i]);
    std::memcpy(bytes.data() + 344, "n+1", 4);
    return bytes;
}

float sampleAt(const fields::Field& field, glm::dvec3 point, double radius)
{
    float value = 0;
    field.sample(
        {std::span(&point.x, 1),
         std::span(&point.y, 1),
         std::span(&point.z, 1),
         std::span(&radius, 1)},
        std::span(&value, 1));
    return value;
}

std::size_t countExcludedSamples(
    const fields::Field& field,
    const core::Box& range,
    std::size_t boxes,
    std::uint32_t seed,
    double mostRadius)
{
    constexpr std::size_t kPoints = 64;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::vector<double> x(kPoints);
    std::vector<double> y(kPoints);
    std::vector<double> z(kPoints);
    std::vector<double> radii(mostRadius > 0 ? kPoints : 0);
    std::vector<float> values(kPoints);
    std::size_t excluded = 0;
    const glm::dvec3 margin = 0.25 * range.size() + 1.0;
    for (std::size_t b = 0; b < boxes; ++b) {
        core::Box box;
        const double scale = std::pow(unit(random), 3.0); // mostly small boxes
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double from = range.low[axis] - margin[axis];
            const double size = range.size()[axis] + 2 * margin[axis];
            box.low[axis] = from + size * unit(random);
            box.high[axis] = box.low[axis] + size * scale * unit(random);
            if (b % 3 == 0) { // on voxel planes
                box.low[axis] = std::round(box.low[axis]);
                box.high[axis] = std::max(std::round(box.high[axis]), box.low[axis]);
            }
        }
        const auto between = [&](std::size_t axis) {
            const double t = unit(random);
            // The corners and faces of the box are part of it.
            return t < 0.1 ? box.low[axis]
                   : t > 0.9
                       ? box.high[axis]
                       : std::min(box.high[axis], box.low[axis] + unit(random) * box.size()[axis]);
        };
        for (std::size_t i = 0; i < kPoints; ++i) {
            x[i] = between(0);
            y[i] = between(1);
            z[i] = between(2);
        }
        core::Interval radius{0, 0};
        if (mostRadius > 0) { // of all magnitudes, from 0 on in every other box
            radius.high = mostRadius * std::pow(unit(random), 4.0);
            radius.low = b % 2 == 0 ? 0.0 : radius.high * unit(random);
            for (double& each : radii) {
                const double t = unit(random);
                each = t < 0.2   ? radius.low
                       : t < 0.4 ? radius.high
                                 : std::min(
                                       radius.high,
                                       radius.low + unit(random) * (radius.high - radius.low));
            }
        }
        field.sample({x, y, z, radii}, values);
        const core::Interval bounds = field.bounds(box, radius);
        for (const float value : values) {
            const double cleaned =
                std::isnan(value) ? -std::numeric_limits<double>::infinity() : double{value};
            if (!bounds.contains(cleaned))
                ++excluded;
        }
    }
    return excluded;
}

} // namespace isofront::test
