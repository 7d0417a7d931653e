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

void Samples::place(
    const hierarchy::Tetrahedron& cell,
    const CellGeometry& geometry,
    const hierarchy::Domain& domain,
    const VolumeMesh& mesh,
    const ExtractionSettings& settings)
{
    const std::size_t count = mesh.vertexCount();
    for (auto* column : {&px, &py, &pz, &x, &y, &z})
        column->resize(count);

    const auto& w = mesh.weightColumns;
    const double unit = domain.latticeUnit() / mesh.denominator();
    std::array<std::array<double, 3>, 4> corners{};
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t axis = 0; axis < 3; ++axis)
            corners[k][axis] = cell.corner[k][axis];
    placePoints(
        {w[0].data(), w[1].data(), w[2].data(), w[3].data()},
        corners,
        {domain.origin.x, domain.origin.y, domain.origin.z},
        unit,
        count,
        {{px.data(), py.data(), pz.data()}, {x.data(), y.data(), z.data()}});

    radius.clear();
    if (settings.filterStrength <= 0)
        return;
    radius.resize(count);
    const double* w0 = w[geometry.sorted[0]].data();
    const double* w1 = w[geometry.sorted[1]].data();
    const double* w2 = w[geometry.sorted[2]].data();
    const double* w3 = w[geometry.sorted[3]].data();
    const auto& s = geometry.edgeRadius;
    for (std::size_t i = 0; i < count; ++i) {
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

void Samples::take(
    const fields::Field& field,
    const std::optional<core::Box>& dataBox,
    const ExtractionSettings& settings)
{
    const std::size_t count = x.size();
    value.resize(count);
    field.sample({x, y, z, radius}, value);
    sanitised = sanitise(value);

    inside.resize(count);
    const float least = leastFloatFrom(settings.isovalue);
    for (std::size_t i = 0; i < count; ++i)
        inside[i] = value[i] >= least ? 1 : 0;

    boxDistance.clear();
    if (!dataBox)
        return;
    boxDistance.resize(count);
    const glm::dvec3& low = dataBox->low;
    const glm::dvec3& high = dataBox->high;
    for (std::size_t i = 0; i < count; ++i) {
        const double dx = std::min(x[i] - low.x, high.x - x[i]);
        const double dy = std::min(y[i] - low.y, high.y - y[i]);
        const double dz = std::min(z[i] - low.z, high.z - z[i]);
        boxDistance[i] = std::min({dx, dy, dz});
        if (boxDistance[i] < 0)
            inside[i] = 0;
    }
}

} // namespace isofront::extractor
