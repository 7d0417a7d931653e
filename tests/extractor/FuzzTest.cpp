#include "support/FunctionField.h"
#include "support/GlobalMesh.h"
#include "support/RandomFront.h"

#include <isofront/extractor/CellExtractor.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

namespace isofront::extractor {
namespace {

/// What one trial tries, so that a failure can be repeated and understood.
struct Trial {
    std::string field;
    hierarchy::Domain domain;
    ExtractionSettings settings;
    std::size_t cells = 0;

    [[nodiscard]] std::string text() const
    {
        return field + ", n = " + std::to_string(settings.latticeSize) +
               ", filter = " + std::to_string(settings.filterStrength) +
               ", isovalue = " + std::to_string(settings.isovalue) +
               ", closed = " + std::to_string(settings.closed) +
               ", smooth = " + std::to_string(settings.smoothIterations) +
               ", reproject = " + std::to_string(settings.reproject) +
               ", simplify = " + std::to_string(settings.simplifyError) + " by " +
               std::to_string(settings.simplifyChoices) +
               ", normals = " + std::to_string(static_cast<int>(settings.normals)) +
               ", vertices = " + std::to_string(static_cast<int>(settings.vertices)) +
               ", align = " + std::to_string(settings.alignEdges) +
               ", edge = " + std::to_string(domain.edge) +
               ", origin = " + std::to_string(domain.origin.x) + ", " + std::to_string(cells) +
               " cells";
    }
};

/// A field in the unit cube, by number, and a range of isovalues that cut it.
struct Kind {
    const char* name;
    double low, high;
    double (*value)(const glm::dvec3& unit, const glm::dvec3& p, double radius, std::uint64_t seed);
};

const std::array<Kind, 8> kKinds{{
    {"noise of single bits",
     -0.5,
     0.5,
     [](const glm::dvec3&, const glm::dvec3& p, double radius, std::uint64_t seed) {
         return tests::hashed(p, radius, seed);
     }},
    {"three values",
     -1,
     1,
     [](const glm::dvec3&, const glm::dvec3& p, double radius, std::uint64_t seed) {
         return std::floor(1.5 * (tests::hashed(p, radius, seed) + 1.0)) - 1.0;
     }},
    {"small integers, mostly one",
     0,
     3,
     [](const glm::dvec3&, const glm::dvec3& p, double radius, std::uint64_t seed) {
         const double h = tests::hashed(p, radius, seed);
         return h > 0.6 ? std::floor(20 * (h - 0.6)) - 2 : 1.0;
     }},
    {"NaN and infinities in noise",
     -0.5,
     0.5,
     [](const glm::dvec3&, const glm::dvec3& p, double radius, std::uint64_t seed) {
         const double h = tests::hashed(p, radius, seed);
         if (h > 0.9)
             return std::numeric_limits<double>::quiet_NaN();
         if (h > 0.8)
             return std::numeric_limits<double>::infinity();
         return h < -0.9 ? -std::numeric_limits<double>::infinity() : h;
     }},
    {"values of every magnitude",
     -1e-3,
     1e-3,
     [](const glm::dvec3&, const glm::dvec3& p, double radius, std::uint64_t seed) {
         const double h = tests::hashed(p, radius, seed);
         return std::copysign(
             std::ldexp(1.0, static_cast<int>(280 * std::abs(h)) - 150), std::sin(1e4 * h));
     }},
    {"gyroid",
     -1,
     1,
     [](const glm::dvec3& unit, const glm::dvec3&, double, std::uint64_t seed) {
         return tests::gyroid(unit, 1.0 + double(seed % 5));
     }},
    {"planes through lattice points",
     -0.5,
     0.5,
     [](const glm::dvec3& unit, const glm::dvec3&, double, std::uint64_t seed) {
         const glm::dvec3 d = glm::abs(unit - 0.5);
         return seed % 2 == 0 ? 0.25 - std::max({d.x, d.y, d.z}) : 0.375 - (d.x + d.y + d.z);
     }},
    {"thin shells",
     -0.01,
     0.01,
     [](const glm::dvec3& unit, const glm::dvec3&, double, std::uint64_t seed) {
         const double d = glm::distance(unit, glm::dvec3(0.5));
         return 0.02 - std::abs(std::sin(double(3 + seed % 40) * d) / double(3 + seed % 40));
     }},
}};

/// Random fields, fronts, offsets, lattice sizes, filters and isovalues: no crack, no bit of
/// difference between two cells, whatever is asked for.
/// ISOFRONT_TEST_INTENSITY multiplies the number of trials.
TEST(Fuzz, noCombinationOfSettingsCracks)
{
    const int trials = tests::trials(24);
    std::size_t triangles = 0;
    for (int trial = 0; trial < trials; ++trial) {
        const auto seed = static_cast<std::uint64_t>(1000 + trial);
        auto generator = tests::random(seed);
        const Kind& kind = kKinds[tests::below(generator, kKinds.size())];
        Trial t;
        t.field = kind.name;
        const std::array<double, 6> offsets{0, 1, 1e3, 1e5, 6.4e6, 1e9};
        const double offset = offsets[tests::below(generator, offsets.size())];
        for (std::size_t axis = 0; axis < 3; ++axis)
            t.domain.origin[axis] = tests::uniform(generator, -offset, offset);
        // Not so small that its samples fall together so far from the origin.
        t.domain.edge = std::max(std::pow(10.0, tests::uniform(generator, -6, 8)), 1e-6 * offset);
        const std::array<int, 5> sizes{1, 2, 4, 8, 16};
        t.settings.latticeSize = sizes[tests::below(generator, sizes.size())];
        t.settings.filterStrength =
            tests::below(generator, 3) == 0 ? 0.0 : tests::uniform(generator, 0.1, 3);
        t.settings.cornerRadius = std::pow(10.0, tests::uniform(generator, -6, -1)) * t.domain.edge;
        t.settings.closed = tests::below(generator, 2) == 0;
        t.settings.isovalue = tests::below(generator, 2) == 0
                                  ? std::round(tests::uniform(generator, kind.low, kind.high))
                                  : tests::uniform(generator, kind.low, kind.high);
        const bool smooth = kind.value == kKinds[5].value || kind.value == kKinds[7].value;
        t.settings.smoothIterations = static_cast<int>(tests::below(generator, 4));
        t.settings.reproject = tests::below(generator, 2) == 0;
        t.settings.simplifyError = tests::below(generator, 3) == 0
                                       ? 0.0
                                       : std::pow(10.0, tests::uniform(generator, -2, 1));
        t.settings.simplifyChoices = static_cast<int>(1 + tests::below(generator, 16));
        t.settings.normals = static_cast<NormalSource>(tests::below(generator, 3));
        t.settings.vertices = static_cast<VertexPlacement>(tests::below(generator, 2));
        t.settings.alignEdges = tests::below(generator, 2) == 0;
        const std::uint64_t fieldSeed = generator();
        const hierarchy::Domain& domain = t.domain;
        const auto field = std::make_shared<tests::FunctionField>(
            [&, fieldSeed](const glm::dvec3& p, double radius) {
                const glm::dvec3 unit = (p - domain.origin) / domain.edge;
                return kind.value(unit, p, radius, fieldSeed);
            },
            1e-4 * domain.edge);
        const int n = t.settings.latticeSize;
        const hierarchy::Front front = tests::randomFront(
            generator,
            n >= 8 ? 1 : 3,
            n >= 8 ? 8 : 24,
            tests::below(
                generator,
                n >= 16  ? 2
                : n >= 8 ? 4
                         : 16));
        t.cells = front.cellCount();
        SCOPED_TRACE("seed " + std::to_string(seed) + ": " + t.text());

        const CellExtractor extractor(field, t.domain, t.settings);
        const tests::GlobalMesh mesh = tests::extractFront(front, extractor);
        const auto defects = mesh.defects();
        EXPECT_EQ(defects.nonManifold, 0U);
        EXPECT_EQ(defects.misoriented, 0U);
        EXPECT_EQ(mesh.differingCopies, 0U);
        if (t.settings.closed) {
            EXPECT_EQ(defects.open, 0U);
        } else {
            for (const auto& [a, b] : mesh.openEdges()) {
                bool onWall = false;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    for (const double wall :
                         {t.domain.origin[axis], t.domain.origin[axis] + t.domain.edge})
                        onWall = onWall || (a[axis] == wall && b[axis] == wall);
                EXPECT_TRUE(onWall);
            }
        }
        if (smooth) {
            EXPECT_EQ(defects.degenerate, 0U);
        }
        triangles += mesh.triangles.size();
        if (HasFailure())
            break;
    }
    EXPECT_GT(triangles, 500U * static_cast<std::size_t>(trials));
}

} // namespace
} // namespace isofront::extractor
