#include "render/support/RenderFixture.h"

#include <algorithm>
#include <map>
#include <random>

namespace isofront::test {
namespace {

constexpr double kEdge = 1000.0;

hierarchy::View fromOutside()
{
    return lookingAt({-300, -500, 900}, {500, 500, 450});
}

std::vector<surface::CellId> idsOf(const std::vector<surface::ShownCell>& cells)
{
    std::vector<surface::CellId> ids;
    for (const surface::ShownCell& cell : cells)
        ids.push_back(cell.id);
    return ids;
}

std::uint64_t bytesOf(const std::vector<surface::ShownCell>& cells)
{
    std::uint64_t bytes = 0;
    for (const surface::ShownCell& cell : cells)
        bytes += cell.mesh()->vertices.size() * 12 + cell.mesh()->indices.size() * 2;
    return bytes;
}

class Deltas : public RenderFixture {
protected:
    hierarchy::Domain domain{.edge = kEdge};
};

TEST_F(Deltas, keepThePictureWhenNewCellsCarryTheSameGeometry)
{
    const GridMesh mesh = sphere(glm::dvec3(0.5), 0.3, 32);
    const auto before = cut(mesh, 5, 1);
    const auto after = cut(mesh, 4, 2);
    const auto shown = renderer(domain);
    show(*shown, showing(before));
    const Shot first = shoot(*shown, fromOutside());
    surface::Delta step = showing(after, 2);
    step.removed = idsOf(before);
    show(*shown, step);
    const Shot second = shoot(*shown, fromOutside());
    EXPECT_EQ(first, second);
    EXPECT_EQ(second.stats.uploadedBytes, bytesOf(after));
    EXPECT_EQ(shown->cellCount(), after.size());
    EXPECT_EQ(second.stats.triangles, mesh.triangles.size());
    EXPECT_EQ(second.stats.cellsDrawn + second.stats.cellsCulled, after.size());
}

TEST_F(Deltas, giveTheSameBytesTwiceStagedOrNotIndirectOrNot)
{
    const surface::Delta delta = showing(cut(sphere({0.5, 0.4, 0.6}, 0.25, 24), 4, 3));
    std::vector<Shot> shots;
    for (const bool staged : {false, false, true}) {
        for (const bool direct : {false, true}) {
            render::RendererOptions options = smallOptions();
            options.forceStaging = staged;
            options.forceDirectDraws = direct;
            const auto shown = renderer(domain, options);
            show(*shown, delta);
            shots.push_back(shoot(*shown, fromOutside()));
            shots.push_back(shoot(*shown, fromOutside()));
        }
    }
    for (const Shot& shot : shots)
        EXPECT_EQ(shot, shots.front());
}

TEST_F(Deltas, neverDisturbWhatStaysUnderRandomChange)
{
    for (const bool staged : {false, true}) {
        // So small that slabs are emptied, moved, used again and waited for.
        render::RendererOptions options = smallOptions();
        options.poolBytes = 400U << 10U;
        options.slabBytes = 16U << 10U;
        options.forceStaging = staged;
        const auto shown = renderer(domain, options);
        const auto cells = cut(sphere(glm::dvec3(0.5), 0.3, 36), 8, 5);
        std::mt19937 random(31);
        std::map<std::size_t, bool> present;
        std::uint64_t moved = 0;
        for (int step = 1; step <= 60; ++step) {
            surface::Delta delta;
            delta.version = static_cast<std::uint64_t>(step);
            const unsigned chance = step % 20 < 10 ? 12 : 45;
            for (std::size_t i = 0; i < cells.size(); ++i) {
                if (random() % 100 < 70)
                    continue;
                const bool wanted = random() % 100 >= chance;
                if (present[i])
                    delta.removed.push_back(cells[i].id);
                if (wanted)
                    delta.added.push_back(cells[i]);
                present[i] = wanted;
            }
            const auto stats = shown->apply(delta);
            ASSERT_TRUE(stats) << stats.error().message;
            moved += stats->movedBytes;
            ASSERT_TRUE(shown->draw(fromOutside(), {}));
            if (step % 10 != 0)
                continue;
            std::vector<surface::ShownCell> all;
            for (std::size_t i = 0; i < cells.size(); ++i) {
                if (present[i])
                    all.push_back(cells[i]);
            }
            ASSERT_EQ(shown->cellCount(), all.size());
            const auto fresh = renderer(domain);
            show(*fresh, showing(all));
            ASSERT_EQ(shoot(*shown, fromOutside()), shoot(*fresh, fromOutside())) << step;
        }
        EXPECT_GT(moved, 0U) << "no slab was ever emptied";
    }
}

TEST_F(Deltas, areRefusedWholeWhenTheyDoNotFit)
{
    render::RendererOptions options = smallOptions();
    options.poolBytes = 256U << 10U;
    options.slabBytes = 32U << 10U;
    const auto shown = renderer(domain, options);
    const auto small = cut(sphere(glm::dvec3(0.5), 0.3, 24), 4, 1);
    show(*shown, showing(small));
    const Shot before = shoot(*shown, fromOutside());
    surface::Delta step = showing(cut(sphere(glm::dvec3(0.5), 0.35, 96), 5, 2, 1), 2);
    step.removed = {small.front().id};
    for (int attempt = 0; attempt < 3; ++attempt) {
        const auto stats = shown->apply(step);
        ASSERT_FALSE(stats);
        EXPECT_EQ(stats.error().code, core::ErrorCode::resourceLimit);
        EXPECT_EQ(shown->cellCount(), small.size());
        EXPECT_EQ(shoot(*shown, fromOutside()), before);
    }
    EXPECT_EQ(shoot(*shown, fromOutside()).stats.poolBytesUsed, before.stats.poolBytesUsed);
}

TEST_F(Deltas, mayReplaceEverythingInAPoolThatHoldsItOnlyOnce)
{
    for (const bool staged : {false, true}) {
        const auto cells = cut(sphere(glm::dvec3(0.5), 0.3, 32), 3, 1);
        render::RendererOptions options = smallOptions();
        options.slabBytes = 48U << 10U;
        options.poolBytes = bytesOf(cells) * 3 / 2;
        options.forceStaging = staged;
        const auto shown = renderer(domain, options);
        show(*shown, showing(cells));
        const Shot first = shoot(*shown, fromOutside());
        for (std::uint64_t version = 2; version < 6; ++version) {
            surface::Delta step = showing(cells, version);
            step.removed = idsOf(cells);
            show(*shown, step);
            EXPECT_EQ(shoot(*shown, fromOutside()), first);
        }
    }
}

TEST_F(Deltas, holdAMeshLargerThanASlab)
{
    render::RendererOptions options = smallOptions();
    options.slabBytes = 4U << 10U;
    const auto cells = cut(sphere(glm::dvec3(0.5), 0.3, 40), 1, 1);
    ASSERT_EQ(cells.size(), 1U);
    const auto shown = renderer(domain, options);
    show(*shown, showing(cells));
    const auto reference = renderer(domain);
    show(*reference, showing(cells));
    EXPECT_EQ(shoot(*shown, fromOutside()), shoot(*reference, fromOutside()));
}

TEST_F(Deltas, areRefusedWholeWhenTheyContradictThemselves)
{
    const auto cells = cut(sphere(glm::dvec3(0.5), 0.3, 12), 2, 1);
    const auto shown = renderer(domain);
    show(*shown, showing(cells));
    const Shot before = shoot(*shown, fromOutside());
    const auto expectRefused = [&](const surface::Delta& delta, core::ErrorCode code) {
        const auto stats = shown->apply(delta);
        ASSERT_FALSE(stats);
        EXPECT_EQ(stats.error().code, code);
        EXPECT_EQ(shown->cellCount(), cells.size());
        EXPECT_EQ(shoot(*shown, fromOutside()), before);
    };
    const surface::CellId other{{1, 2, 3}, 9};
    surface::Delta unknown;
    unknown.removed = {other};
    expectRefused(unknown, core::ErrorCode::usage);
    surface::Delta twiceRemoved;
    twiceRemoved.removed = {cells[0].id, cells[0].id};
    expectRefused(twiceRemoved, core::ErrorCode::usage);
    expectRefused(showing({cells[0]}), core::ErrorCode::usage);
    const surface::ShownCell named(other, cells[0].mesh());
    expectRefused(showing({named, named}), core::ErrorCode::usage);

    const auto expectBad = [&](void (*spoil)(extractor::CellMesh&)) {
        auto mesh = std::make_shared<extractor::CellMesh>(*cells[0].mesh());
        spoil(*mesh);
        surface::Delta delta = showing({surface::ShownCell(other, mesh)});
        delta.removed = {cells[1].id};
        expectRefused(delta, core::ErrorCode::badData);
    };
    expectBad([](extractor::CellMesh& mesh) { mesh.exponent = 0; });
    expectBad([](extractor::CellMesh& mesh) { mesh.exponent = 33; });
    expectBad([](extractor::CellMesh& mesh) { mesh.indices.pop_back(); });
    expectBad([](extractor::CellMesh& mesh) { mesh.indices[4] = 65535; });
    expectBad([](extractor::CellMesh& mesh) { mesh.vertices.clear(); });
}

TEST_F(Deltas, mayBeEmptyOrBringCellsWithoutTriangles)
{
    const auto shown = renderer(domain);
    show(*shown, {});
    const auto nothing = std::make_shared<extractor::CellMesh>();
    show(*shown, showing({surface::ShownCell({{1, 1, 1}, 0}, nothing)}));
    const Shot shot = shoot(*shown, fromOutside());
    EXPECT_EQ(shot.stats.draws, 0U);
    EXPECT_TRUE(std::all_of(shot.depth.begin(), shot.depth.end(), [](float d) { return d <= 0; }));
    surface::Delta removal;
    removal.removed = {{{1, 1, 1}, 0}};
    show(*shown, removal);
    EXPECT_EQ(shown->cellCount(), 0U);
}

} // namespace
} // namespace isofront::test
