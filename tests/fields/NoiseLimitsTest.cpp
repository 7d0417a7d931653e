#include "FieldChecks.h"
#include "Octaves.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace isofront::fields {
namespace {

using test::Random;

// The limits that bounds rest on: what noise could reach if every corner carried the gradient, or
// the value, that makes it largest.

template <std::size_t K>
using Vector = std::array<double, K>;

template <std::size_t K>
double dot(const Vector<K>& a, const Vector<K>& b)
{
    double sum = 0;
    for (std::size_t k = 0; k < K; ++k)
        sum += a[k] * b[k];
    return sum;
}

/// A corner's weight at a place, and its first and second derivative along a direction.
struct Weight {
    double value;
    double slope;
    double curvature;
};

/// Magnitude, slope and second derivative.
struct Worst {
    std::array<double, 3> most{};

    /// Adds a corner that carries the worst of some gradients: weight times gradient .
    /// displacement.
    template <std::size_t K>
    void addGradient(
        const std::vector<Vector<K>>& gradients,
        const Weight& w,
        const Vector<K>& displacement,
        const Vector<K>& direction)
    {
        std::array<double, 3> worst{-1e9, -1e9, -1e9};
        for (const Vector<K>& g : gradients) {
            const double along = dot(g, displacement);
            const double towards = dot(g, direction);
            worst[0] = std::max(worst[0], w.value * along);
            worst[1] = std::max(worst[1], w.value * towards + along * w.slope);
            worst[2] = std::max(worst[2], 2 * w.slope * towards + along * w.curvature);
        }
        for (std::size_t i = 0; i < 3; ++i)
            most[i] += worst[i];
    }

    /// Adds a corner that carries -1 or 1.
    void addValue(const Weight& w)
    {
        most[0] += std::abs(w.value);
        most[1] += std::abs(w.slope);
        most[2] += std::abs(w.curvature);
    }
};

/// The product of the axes' fades towards a corner of the cell.
template <std::size_t K>
Weight fadeTowards(std::size_t corner, const Vector<K>& x, const Vector<K>& direction)
{
    std::array<std::array<double, 3>, K> w{};
    for (std::size_t k = 0; k < K; ++k) {
        const double t = x[k];
        const bool far = ((corner >> k) & 1U) != 0;
        const double s = far ? 1.0 : -1.0;
        const double fade = t * t * t * (t * (t * 6 - 15) + 10);
        w[k] = {
            far ? fade : 1 - fade,
            s * 30 * t * t * (t - 1) * (t - 1),
            s * 60 * t * (2 * t * t - 3 * t + 1)};
    }
    const auto product = [&](std::size_t a, std::size_t b) {
        double result = 1;
        for (std::size_t k = 0; k < K; ++k)
            result *= w[k][(k == a ? 1U : 0U) + (k == b ? 1U : 0U)];
        return result;
    };
    Weight weight{product(K, K), 0, 0};
    for (std::size_t a = 0; a < K; ++a) {
        weight.slope += direction[a] * product(a, K);
        for (std::size_t b = 0; b < K; ++b)
            weight.curvature += direction[a] * direction[b] * product(a, b);
    }
    return weight;
}

/// (r^2 - d^2)^4
template <std::size_t K>
Weight kernel(double squaredRadius, const Vector<K>& d, const Vector<K>& direction)
{
    const double rest = squaredRadius - dot(d, d);
    if (rest <= 0)
        return {0, 0, 0};
    const double towards = dot(d, direction);
    const double cube = rest * rest * rest;
    return {
        cube * rest,
        -8 * cube * towards,
        48 * rest * rest * towards * towards - 8 * cube * dot(direction, direction)};
}

/// Random search over places and directions, then climbing from the best place found.
template <std::size_t K, typename At>
std::array<double, 3> searched(std::uint64_t seed, const At& at)
{
    Random random(seed);
    std::array<double, 3> best{};
    for (std::size_t kind = 0; kind < 3; ++kind) {
        Vector<K> x{};
        Vector<K> u{};
        double step = 1;
        for (int i = 0; i < 12000; ++i) {
            Vector<K> tryX = x;
            Vector<K> tryU = u;
            for (std::size_t k = 0; k < K; ++k) {
                tryX[k] =
                    i < 4000 ? random(0, 1) : std::clamp(x[k] + step * random(-1, 1), 0.0, 1.0);
                tryU[k] = i < 4000 ? random(-1, 1) : u[k] + step * random(-1, 1);
            }
            const double length = std::sqrt(dot(tryU, tryU));
            for (double& component : tryU)
                component /= length;
            const double found = at(tryX, tryU).most[kind];
            if (found > best[kind]) {
                best[kind] = found;
                x = tryX;
                u = tryU;
            } else if (i >= 4000) {
                step = std::max(step * 0.998, 1e-5);
            }
        }
    }
    return best;
}

void expectLimits(
    const std::array<double, 3>& found,
    const std::array<double, 3>& expected,
    const NoiseLimits& limits)
{
    const std::array<float, 3> allowed{limits.magnitude, limits.slope, limits.curvature};
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_LT(found[i], double(allowed[i])) << i;
        EXPECT_NEAR(found[i], expected[i], 0.004 * expected[i]) << i;
    }
}

/// The twelve gradients of space.
std::vector<Vector<3>> edges()
{
    std::vector<Vector<3>> all;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const double a : {-1.0, 1.0}) {
            for (const double b : {-1.0, 1.0}) {
                Vector<3> edge{};
                edge[axis] = a;
                edge[(axis + 1) % 3] = b;
                all.push_back(edge);
            }
        }
    }
    return all;
}

/// The eight gradients of the plane.
std::vector<Vector<2>> turns()
{
    std::vector<Vector<2>> all;
    for (int i = 0; i < 8; ++i) {
        const double angle = (22.5 + 45.0 * i) * 3.141592653589793 / 180;
        all.push_back({std::cos(angle), std::sin(angle)});
    }
    return all;
}

template <std::size_t K>
std::array<double, 3> worstOfValues(std::uint64_t seed)
{
    return searched<K>(seed, [](const Vector<K>& x, const Vector<K>& u) {
        Worst worst;
        for (std::size_t corner = 0; corner < (std::size_t{1} << K); ++corner)
            worst.addValue(fadeTowards<K>(corner, x, u));
        return worst;
    });
}

template <std::size_t K>
std::array<double, 3> worstOfGradients(std::uint64_t seed, const std::vector<Vector<K>>& gradients)
{
    return searched<K>(seed, [&](const Vector<K>& x, const Vector<K>& u) {
        Worst worst;
        for (std::size_t corner = 0; corner < (std::size_t{1} << K); ++corner) {
            Vector<K> d = x;
            for (std::size_t k = 0; k < K; ++k)
                d[k] -= double((corner >> k) & 1U);
            worst.addGradient<K>(gradients, fadeTowards<K>(corner, x, u), d, u);
        }
        return worst;
    });
}

TEST(NoiseLimits, holdForAllValuesAtTheCorners)
{
    expectLimits(worstOfValues<3>(21), {1, 3.75, 14.0625}, spaceLimits(NoiseKind::value));
    expectLimits(worstOfValues<2>(22), {1, 3.75, 14.0625}, planeLimits(NoiseKind::value));
}

TEST(NoiseLimits, holdForAllGradientsAtTheCorners)
{
    expectLimits(
        worstOfGradients<3>(11, edges()), {1.0364, 3.75, 14.466}, spaceLimits(NoiseKind::gradient));
    expectLimits(
        worstOfGradients<2>(12, turns()),
        {0.6608, 2.0671, 8.9773},
        planeLimits(NoiseKind::gradient));
}

TEST(NoiseLimits, holdForAllGradientsOnTetrahedra)
{
    constexpr double kScale = 76.88075;
    const std::vector<Vector<3>> gradients = edges();
    const auto at = [&](const Vector<3>& x, const Vector<3>& u) {
        Worst worst;
        for (int corner = 0; corner < 2 * 64; ++corner) {
            const double half = corner < 64 ? 0.0 : 0.5;
            const Vector<3> d{
                x[0] - double(corner % 4 - 1) - half,
                x[1] - double(corner / 4 % 4 - 1) - half,
                x[2] - double(corner / 16 % 4 - 1) - half};
            worst.addGradient<3>(gradients, kernel<3>(0.5, d, u), d, u);
        }
        for (double& most : worst.most)
            most *= kScale;
        return worst;
    };
    expectLimits(searched<3>(31, at), {1, 6.967, 48.25}, spaceLimits(NoiseKind::simplex));
}

TEST(NoiseLimits, holdForAllGradientsOnTriangles)
{
    constexpr double kScale = 11.66;
    const double height = std::sqrt(0.75);
    const std::vector<Vector<2>> gradients = turns();
    // Places and directions are given along two edges of the triangles, as the noise has them.
    const auto cartesian = [&](double along, double across) {
        return Vector<2>{along + 0.5 * across, height * across};
    };
    const auto at = [&](const Vector<2>& x, const Vector<2>& u) {
        Worst worst;
        for (int corner = 0; corner < 36; ++corner) {
            const Vector<2> d =
                cartesian(x[0] - double(corner % 6 - 2), x[1] - double(corner / 6 - 2));
            const Vector<2> direction = cartesian(u[0], u[1]);
            worst.addGradient<2>(gradients, kernel<2>(0.75, d, direction), d, direction);
        }
        for (double& most : worst.most)
            most *= kScale;
        return worst;
    };
    expectLimits(searched<2>(32, at), {0.7227, 4.935, 36.64}, planeLimits(NoiseKind::simplex));
}

} // namespace
} // namespace isofront::fields
