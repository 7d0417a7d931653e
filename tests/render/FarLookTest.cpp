#include "render/support/VoxelFixture.h"
#include "support/Random.h"

#include <isofront/fields/Procedural.h>
#include <isofront/render/HybridScene.h>
#include <isofront/voxels/FieldVoxelization.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cstdlib>

namespace isofront::test {
namespace {

using render::HybridScene;
using render::HybridSettings;

/// A landscape seen across all of it, as meshes alone and with its distance as voxels.
class FarLook : public VoxelFixture {
protected:
    static constexpr double kFilter = 0.5; ///< of the meshes

    static render::HybridSettings settings()
    {
        HybridSettings settings;
        settings.pixelError = 6;
        settings.handOver.pixels = 1.2; // a small picture, so larger voxels, too
        settings.handOver.meshPixels = settings.pixelError;
        return settings;
    }
    static hierarchy::Domain domainOf(const fields::ProceduralSource& source)
    {
        return {.origin = source.domain.low, .edge = source.domain.size().x};
    }
    static hierarchy::View across(const fields::ProceduralSource& source)
    {
        const core::Box& box = source.domain;
        const glm::dvec3 eye = box.low + glm::dvec3(0.05, 0.05, 0.9) * box.size();
        hierarchy::View view =
            lookingAt(eye, box.low + glm::dvec3(0.7, 0.7, 0.3) * box.size(), 96, 64);
        view.verticalFieldOfView = 0.9;
        return view;
    }

    struct Picture {
        core::Image image;
        std::vector<render::ShownVoxel> voxels;
    };
    /// @param factor  of the filter's strength for voxels; 0 for none of them
    Picture pictureOf(const fields::ProceduralSource& source, double factor)
    {
        const std::shared_ptr<core::Jobs> jobs = core::makeJobs(core::JobsBackend::automatic, 2);
        std::shared_ptr<const voxels::ChunkStore> model;
        if (factor > 0) {
            std::unique_ptr<voxels::ChunkStore> store = voxels::memoryStore();
            const auto report = voxels::voxelizeField(
                *source.field,
                {.isovalue = source.isovalue,
                 .box = source.domain,
                 .edge = source.domain.size().x / 128,
                 .filterStrength = factor * kFilter},
                *store,
                *jobs);
            EXPECT_TRUE(report) << report.error().message;
            EXPECT_FALSE(store->finish({.name = "far", .lattice = report->lattice}));
            model = std::move(store);
        }
        surface::SurfaceOptions surfaceOptions;
        surfaceOptions.extraction.isovalue = source.isovalue;
        surfaceOptions.extraction.filterStrength = kFilter;
        surfaceOptions.pixelError = settings().pixelError;
        surface::Surface surface(source.field, domainOf(source), surfaceOptions, jobs);
        const auto shown = renderer(domainOf(source), options());
        auto scene = HybridScene::create(*shown, &surface, model, jobs, settings());
        EXPECT_TRUE(scene) << scene.error().message;
        const auto frame = scene->settle(across(source), {.antialias = false});
        EXPECT_TRUE(frame) << frame.error().message;
        return {*shown->readImage(), *shown->readVoxels()};
    }

    struct Difference {
        double colour = 0;  ///< between the mean colours of squares, the mean [grey levels]
        double rougher = 0; ///< how much more neighbours differ within squares [grey levels]
        std::size_t squares = 0;
    };
    /// In squares of 8 x 8 pixels that show voxels in the second picture.
    static Difference between(const Picture& meshes, const Picture& voxels)
    {
        constexpr int kSquare = 8;
        Difference sum;
        const int width = meshes.image.width;
        for (int top = 0; top + kSquare <= meshes.image.height; top += kSquare)
            for (int left = 0; left + kSquare <= width; left += kSquare) {
                int far = 0;
                std::array<int, 3> apart{};
                int rougher = 0;
                for (int y = top; y < top + kSquare; ++y)
                    for (int x = left; x < left + kSquare; ++x) {
                        far += voxels.voxels[static_cast<std::size_t>(y * width + x)].isThere;
                        for (std::size_t i = 0; i < 3; ++i) {
                            const auto at = [&](const Picture& picture, int column) {
                                return int{picture.image.pixel(column, y)[i]};
                            };
                            apart[i] += at(voxels, x) - at(meshes, x);
                            if (x > left)
                                rougher += std::abs(at(voxels, x) - at(voxels, x - 1)) -
                                           std::abs(at(meshes, x) - at(meshes, x - 1));
                        }
                    }
                if (far < kSquare * kSquare)
                    continue;
                ++sum.squares;
                const int most =
                    std::max({std::abs(apart[0]), std::abs(apart[1]), std::abs(apart[2])});
                sum.colour += double(most) / (kSquare * kSquare);
                sum.rougher += double(rougher) / (3 * kSquare * (kSquare - 1));
            }
        const double squares = static_cast<double>(std::max<std::size_t>(sum.squares, 1));
        return {sum.colour / squares, sum.rougher / squares, sum.squares};
    }
};

TEST_F(FarLook, isThatOfMeshes)
{
    const std::array<const char*, 2> presets{"alpine", "canyon"};
    for (int trial = 0; trial < tests::trials(2); ++trial) {
        const char* const preset = presets[static_cast<std::size_t>(trial) % presets.size()];
        SCOPED_TRACE(preset);
        const auto source = fields::makeProcedural("terrain", {{"preset", preset}});
        ASSERT_TRUE(source) << source.error().message;
        const Picture meshes = pictureOf(*source, 0);
        const double factor = render::voxelFilterFactor(settings().handOver);
        EXPECT_GT(factor, 5);
        const Difference alike = between(meshes, pictureOf(*source, factor));
        EXPECT_GT(alike.squares, 15U);
        EXPECT_LT(alike.colour, 6);
        EXPECT_LT(std::abs(alike.rougher), 2);
        // and that is because of the filter
        const Difference rough = between(meshes, pictureOf(*source, 1));
        EXPECT_GT(rough.rougher, 2 * std::abs(alike.rougher) + 1);
    }
}

TEST_F(FarLook, needsNoMoreFilterWhereMeshesAreAsFineAsVoxels)
{
    render::HandOverSettings settings{.pixels = 0.6, .meshPixels = 0.01};
    EXPECT_EQ(render::voxelFilterFactor(settings), 1);
    settings.meshPixels = 3;
    const double factor = render::voxelFilterFactor(settings);
    EXPECT_GT(factor, 1);
    // only how many voxels there are to a step of the mesh counts
    settings.pixels *= 2;
    settings.meshPixels *= 2;
    EXPECT_EQ(render::voxelFilterFactor(settings), factor);
    settings.pixels *= 2;
    EXPECT_EQ(render::voxelFilterFactor(settings), factor / 2);
}

} // namespace
} // namespace isofront::test
