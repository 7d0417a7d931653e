#include "Samples.h"

#include "SampleKernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace isofront::extractor {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kHuge = std::numeric_limits<float>::max() / 4;

/// The smallest float that is not below a number: floats compare with it as with the number.
float leastFloatFrom(double number)
{
    const auto nearest = static_cast<float>(number);
    return double(nearest) < number ? std::nextafter(nearest, kInfinity) : nearest;
}

} // namespace

std::uint32_t sanitise(std::span<float> values)
{
    // without branches, so that it is done for many values at once
    std::uint32_t changed = 0;
    for (float& value : values) {
        const float bound = value > 0 ? kHuge : -kHuge; // NaN is not above zero
        const bool isFine = std::abs(value) <= kHuge;
        value = isFine ? value : bound;
        changed += isFine ? 0U : 1U;
    }
    return changed;
}

void Samples::take(
    const fields::Field& field,
    const hierarchy::Tetrahedron& cell,
    const CellGeometry& geometry,
    const hierarchy::Domain& domain,
    const std::optional<core::Box>& dataBox,
    const ExtractionSettings& settings)
{
    mesh = &VolumeMesh::ofSize(settings.latticeSize);
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t axis = 0; axis < 3; ++axis)
            corners[k][axis] = std::int64_t{cell.corner[k][axis]};
    const std::size_t total = mesh->vertexCount();
    const bool filtered = settings.filterStrength > 0;
    value.resize(total);
    inside.resize(total);
    radius.resize(filtered ? total : 0);
    boxDistance.resize(dataBox ? total : 0);
    sanitised = 0;

    const auto& w = mesh->weightColumns;
    const double unit = domain.latticeUnit() / mesh->denominator();
    const float least = leastFloatFrom(settings.isovalue);
    auto& [x, y, z] = _points;
    for (std::size_t begin = 0; begin < total; begin += kBlock) {
        const std::size_t count = std::min(kBlock, total - begin);
        placePoints(
            {w[0].data() + begin, w[1].data() + begin, w[2].data() + begin, w[3].data() + begin},
            realCorners(),
            {domain.origin.x, domain.origin.y, domain.origin.z},
            unit,
            count,
            {x.data(), y.data(), z.data()});
        fields::SampleBatch batch{
            std::span(x).first(count), std::span(y).first(count), std::span(z).first(count)};
        if (filtered) {
            placeRadii(geometry, settings, begin, count);
            batch.radius = std::span<const double>(radius).subspan(begin, count);
        }
        const auto values = std::span(value).subspan(begin, count);
        field.sample(batch, values);
        sanitised += sanitise(values);
        for (std::size_t i = 0; i < count; ++i)
            inside[begin + i] = values[i] >= least ? 1 : 0;
        if (!dataBox)
            continue;
        const glm::dvec3& low = dataBox->low;
        const glm::dvec3& high = dataBox->high;
        for (std::size_t i = 0; i < count; ++i) {
            const double dx = std::min(x[i] - low.x, high.x - x[i]);
            const double dy = std::min(y[i] - low.y, high.y - y[i]);
            const double dz = std::min(z[i] - low.z, high.z - z[i]);
            const double distance = std::min({dx, dy, dz});
            boxDistance[begin + i] = distance;
            if (distance < 0)
                inside[begin + i] = 0;
        }
    }
}

void Samples::placeRadii(
    const CellGeometry& geometry,
    const ExtractionSettings& settings,
    std::size_t begin,
    std::size_t count)
{
    const auto& w = mesh->weightColumns;
    const double* w0 = w[geometry.sorted[0]].data();
    const double* w1 = w[geometry.sorted[1]].data();
    const double* w2 = w[geometry.sorted[2]].data();
    const double* w3 = w[geometry.sorted[3]].data();
    const auto& s = geometry.edgeRadius;
    for (std::size_t i = begin; i < begin + count; ++i) {
        // products of weights are exact, and so is their sum; the radii are summed in sorted order
        const double a = w0[i] * w1[i];
        const double b = w0[i] * w2[i];
        const double c = w0[i] * w3[i];
        const double d = w1[i] * w2[i];
        const double e = w1[i] * w3[i];
        const double f = w2[i] * w3[i];
        const double sum = a + b + c + d + e + f;
        const double weighted =
            ((((s[0] * a + s[1] * b) + s[2] * c) + s[3] * d) + s[4] * e) + s[5] * f;
        const double own = sum > 0 ? weighted / sum : settings.cornerRadius;
        radius[i] = settings.filterStrength * own;
    }
}

} // namespace isofront::extractor
