#include "support/FunctionField.h"
#include "support/GlobalMesh.h"
#include "support/RandomFront.h"

#include <isofront/extractor/CellExtractor.h>

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <map>
#include <memory>

namespace isofront::extractor {
namespace {

const glm::dvec3 kCentre(0.503, 0.491, 0.507);

/// Not a distance, so that differences are not exact.
std::shared_ptr<const fields::Field> bump(double step)
{
    return std::make_shared<tests::FunctionField>(
        [](const glm::dvec3& p, double) {
            const glm::dvec3 q = p - kCentre;
            return std::exp(-8 * glm::dot(q, q) * (1 + 0.5 * p.x)) - 0.4;
        },
        step);
}

glm::dvec3 bumpNormal(const glm::dvec3& p)
{
    const glm::dvec3 q = p - kCentre;
    return glm::normalize(2.0 * q * (1 + 0.5 * p.x) + glm::dvec3(0.5 * glm::dot(q, q), 0, 0));
}

double worstNormalError(NormalSource source, double step)
{
    const CellExtractor extractor(
        bump(step), {}, {.latticeSize = 4, .filterStrength = 0, .normals = source});
    double worst = 0;
    tests::uniformFront(6).forEachCell(
        [&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
            const auto mesh = extractor.extract(cell);
            for (const CellVertex& vertex : mesh->vertices) {
                const glm::dvec3 p = extractor.domain().fieldFromGrid(mesh->gridPosition(vertex));
                const double cosine = glm::dot(fromOctahedral(vertex.normal), bumpNormal(p));
                worst = std::max(worst, std::acos(std::min(1.0, cosine)));
            }
        });
    return worst;
}

TEST(Normals, bySixSamplesAreOfSecondOrderAndByFourOfFirst)
{
    const double six = worstNormalError(NormalSource::sixSamples, 4e-2);
    const double four = worstNormalError(NormalSource::fourSamples, 4e-2);
    EXPECT_NEAR(six / worstNormalError(NormalSource::sixSamples, 2e-2), 4.0, 0.6);
    EXPECT_NEAR(four / worstNormalError(NormalSource::fourSamples, 2e-2), 2.0, 0.3);
    EXPECT_LT(six, four);
}

TEST(Normals, areTheFieldsOwnUnlessDifferencesAreAskedFor)
{
    /// Its gradient is a lie, so that one sees who asked.
    class Liar final : public fields::Field {
    public:
        void sample(const fields::SampleBatch& batch, std::span<float> values) const override
        {
            for (std::size_t i = 0; i < batch.size(); ++i)
                values[i] = static_cast<float>(0.4 - batch.z[i]);
        }
        void
        gradient(const fields::SampleBatch& batch, fields::GradientSpans gradients) const override
        {
            for (std::size_t i = 0; i < batch.size(); ++i) {
                gradients.x[i] = -1;
                gradients.y[i] = gradients.z[i] = 0;
            }
        }
        [[nodiscard]] core::Interval bounds(const core::Box&, core::Interval) const override
        {
            return {};
        }
        [[nodiscard]] double differenceStep(double) const override { return 1e-3; }
    };
    const auto normalWith = [](NormalSource source) {
        const CellExtractor extractor(
            std::make_shared<Liar>(), {}, {.latticeSize = 4, .normals = source});
        const auto mesh = extractor.extract(hierarchy::rootTetrahedra()[0]);
        EXPECT_FALSE(mesh->vertices.empty());
        return fromOctahedral(mesh->vertices.front().normal);
    };
    EXPECT_GT(normalWith(NormalSource::analytic).x, 0.999);
    EXPECT_GT(normalWith(NormalSource::sixSamples).z, 0.999);
    EXPECT_GT(normalWith(NormalSource::fourSamples).z, 0.999);
}

TEST(Normals, haveTheSameBitsInAllCellsAroundABorder)
{
    auto generator = tests::random(71);
    const hierarchy::Front front = tests::randomFront(generator, 4, 10, 12);
    for (const NormalSource source :
         {NormalSource::analytic, NormalSource::sixSamples, NormalSource::fourSamples}) {
        const tests::GlobalMesh mesh = tests::extractFront(
            front,
            CellExtractor(
                bump(1e-3), {}, {.latticeSize = 4, .cornerRadius = 1e-3, .normals = source}));
        EXPECT_GT(mesh.sharedCopies, 100U);
        EXPECT_EQ(mesh.differingCopies, 0U);
    }
}

TEST(Normals, followTheTrianglesWhereTheFieldIsAPlateau)
{
    // two values and nothing between them: no difference sees a slope but at the step itself
    const auto field = std::make_shared<tests::FunctionField>(
        [](const glm::dvec3& p, double) { return glm::distance(p, kCentre) < 0.37 ? 1.0 : -1.0; },
        1e-9);
    for (const NormalSource source : {NormalSource::sixSamples, NormalSource::fourSamples}) {
        const CellExtractor extractor(
            field, {}, {.latticeSize = 8, .filterStrength = 0, .normals = source});
        double sum = 0;
        std::size_t inner = 0;
        tests::uniformFront(5).forEachCell([&](const hierarchy::CellId&,
                                               const hierarchy::Tetrahedron& cell) {
            const auto mesh = extractor.extract(cell);
            for (const CellVertex& vertex : mesh->vertices) {
                const glm::dvec3 p = extractor.domain().fieldFromGrid(mesh->gridPosition(vertex));
                const glm::dvec3 normal = fromOctahedral(vertex.normal);
                EXPECT_NEAR(glm::length(normal), 1.0, 1e-6);
                if ((vertex.flags & CellVertex::border) != 0)
                    continue;
                const double cosine = glm::dot(normal, glm::normalize(p - kCentre));
                EXPECT_GT(cosine, 0.2);
                sum += cosine;
                ++inner;
            }
        });
        EXPECT_GT(inner, 500U);
        EXPECT_GT(sum / static_cast<double>(inner), 0.85) << "edges of the lattice give 0.82";
    }
}

/// Paints space in stripes, and tells radii apart.
class Painted final : public fields::Field {
public:
    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        for (std::size_t i = 0; i < batch.size(); ++i)
            values[i] = static_cast<float>(
                tests::sphere({batch.x[i], batch.y[i], batch.z[i]}, kCentre, 0.37));
    }
    [[nodiscard]] bool hasAttributes() const override { return true; }
    void attributes(const fields::SampleBatch& batch, std::span<std::uint32_t> words) const override
    {
        for (std::size_t i = 0; i < batch.size(); ++i)
            words[i] = word(
                {batch.x[i], batch.y[i], batch.z[i]}, batch.radius.empty() ? 0 : batch.radius[i]);
    }
    static std::uint32_t word(const glm::dvec3& p, double radius)
    {
        return static_cast<std::uint32_t>(
            std::bit_cast<std::uint64_t>(tests::hashed(p, radius, 9)) >> 20U);
    }
    [[nodiscard]] core::Interval bounds(const core::Box&, core::Interval) const override
    {
        return {};
    }
    [[nodiscard]] double differenceStep(double) const override { return 1e-3; }
};

TEST(Attributes, areTheFieldsWordsAtTheVerticesAndAlikeInAllCells)
{
    auto generator = tests::random(72);
    const hierarchy::Front front = tests::randomFront(generator, 4, 10, 12);
    const auto field = std::make_shared<Painted>();
    for (const double filter : {0.0, 1.0}) {
        const CellExtractor extractor(
            field,
            {},
            {.latticeSize = 4, .filterStrength = filter, .cornerRadius = 1e-3, .attributes = true});
        std::map<std::array<std::int64_t, 3>, std::uint32_t> known;
        std::size_t shared = 0;
        front.forEachCell([&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
            CellTrace trace;
            const auto mesh = extractor.extract(cell, &trace);
            ASSERT_EQ(mesh->attributes.size(), mesh->vertices.size());
            for (std::size_t i = 0; i < mesh->vertices.size() && filter == 0; ++i)
                ASSERT_EQ(
                    mesh->attributes[i],
                    Painted::word(
                        extractor.domain().fieldFromGrid(mesh->gridPosition(mesh->vertices[i])),
                        0));
            for (const BorderVertex& border : trace.borders) {
                const auto [found, isNew] =
                    known.emplace(border.key, mesh->attributes[border.vertex]);
                ASSERT_EQ(found->second, mesh->attributes[border.vertex]);
                shared += isNew ? 0U : 1U;
            }
        });
        EXPECT_GT(shared, 100U);
    }
}

TEST(Attributes, areLeftOutUnlessAskedForAndThere)
{
    const auto extracted = [](std::shared_ptr<const fields::Field> field, bool asked) {
        const CellExtractor extractor(
            std::move(field), {}, {.latticeSize = 4, .attributes = asked});
        return extractor.extract(hierarchy::rootTetrahedra()[0]);
    };
    EXPECT_FALSE(extracted(bump(1e-3), true)->vertices.empty());
    EXPECT_TRUE(extracted(bump(1e-3), true)->attributes.empty());
    const auto without = extracted(std::make_shared<Painted>(), false);
    const auto with = extracted(std::make_shared<Painted>(), true);
    EXPECT_TRUE(without->attributes.empty());
    EXPECT_EQ(without->vertices, with->vertices);
    EXPECT_EQ(with->bytes(), without->bytes() + 4 * with->vertices.size());
}

} // namespace
} // namespace isofront::extractor
