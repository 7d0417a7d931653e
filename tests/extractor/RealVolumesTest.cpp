#include <isofront/extractor/CellExtractor.h>
#include <isofront/volume/LoadVolume.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <ostream>

namespace isofront::extractor {
namespace {

struct Real {
    const char* file;
    bool isShipped;
    double isovalue;
};

void PrintTo(const Real& real, std::ostream* stream)
{
    *stream << real.file;
}

/// Volumes as they come from scanners and simulations, cell by cell.
class RealVolumeCells : public testing::TestWithParam<Real> {
protected:
    static constexpr int kLattice = 4;

    void SetUp() override
    {
        const char* folder =
            GetParam().isShipped ? ISOFRONT_DATA : std::getenv("ISOFRONT_TEST_DATA");
        if (folder == nullptr)
            GTEST_SKIP() << "ISOFRONT_TEST_DATA names no folder with volumes/";
        const auto path = std::filesystem::path(folder) / "volumes" / GetParam().file;
        if (!std::filesystem::exists(path))
            GTEST_SKIP() << path << " is not there";
        auto loaded = volume::loadVolume(path);
        ASSERT_TRUE(loaded) << loaded.error().message;
        _volume = std::move(*loaded);
        // One lattice step for a voxel.
        for (double step = _volume.domainEdge / (2 * kLattice); step > 1; step /= 2)
            _nativeLevel += 3;
    }

    struct Counts {
        std::size_t empty = 0;   ///< cells that have no triangle
        std::size_t skipped = 0; ///< those that bounds prove to have none
    };

    /// Extracts cells of a level with and without the test for empty cells and compares.
    /// @param stride  takes one of so many cells that meet the data
    Counts compare(int level, double filterStrength, std::size_t stride) const
    {
        const hierarchy::Domain domain{_volume.domainOrigin, _volume.domainEdge};
        ExtractionSettings settings{
            .latticeSize = kLattice,
            .isovalue = GetParam().isovalue,
            .filterStrength = filterStrength,
            .cornerRadius = 2.0 / 64};
        const CellExtractor skipping(_volume.field, domain, settings);
        settings.skipEmptyCells = false;
        const CellExtractor thorough(_volume.field, domain, settings);
        Counts counts;
        std::size_t met = 0;
        const std::function<void(const hierarchy::Tetrahedron&)> visit =
            [&](const hierarchy::Tetrahedron& cell) {
                const glm::dvec3 low = domain.fieldFromLattice(cell.low());
                for (std::size_t axis = 0; axis < 3; ++axis)
                    if (low[axis] >= _volume.dataBox.high[axis])
                        return;
                if (cell.level < level) {
                    for (const hierarchy::Tetrahedron& half : cell.bisected())
                        visit(half);
                    return;
                }
                if (met++ % stride != 0)
                    return;
                const auto a = skipping.extract(cell);
                const auto b = thorough.extract(cell);
                ASSERT_EQ(a->vertices, b->vertices);
                ASSERT_EQ(a->indices, b->indices);
                ASSERT_EQ(a->exponent, b->exponent);
                counts.empty += b->indices.empty() ? 1U : 0U;
                counts.skipped += a->stats.provedEmpty ? 1U : 0U;
            };
        for (const hierarchy::Tetrahedron& root : hierarchy::rootTetrahedra())
            visit(root);
        return counts;
    }

    volume::LoadedVolume _volume;
    int _nativeLevel = 0;
};

TEST_P(RealVolumeCells, areTheSameWithAndWithoutTheEmptyCellTestWhichSkipsNearlyAll)
{
    const Counts counts = compare(_nativeLevel, 0.0, 1);
    const double share = static_cast<double>(counts.skipped) / static_cast<double>(counts.empty);
    std::cout << GetParam().file << ": " << counts.skipped << " of " << counts.empty
              << " empty cells skipped, " << 100 * share << " %\n";
    RecordProperty("skipped_percent", std::to_string(100 * share));
    EXPECT_GE(share, 0.95);
}

TEST_P(RealVolumeCells, areTheSameWithAndWithoutTheEmptyCellTestAtEveryFilterStrength)
{
    for (const double strength : {0.0, 1.0, 2.0}) {
        for (int coarser = 0; coarser <= 5; ++coarser) {
            const int level = _nativeLevel - coarser;
            const std::size_t stride = std::max(std::size_t{1}, (std::size_t{1} << level) / 512);
            const Counts counts = compare(level, strength, stride);
            std::cout << GetParam().file << ": strength " << strength << ", level " << level << ": "
                      << counts.skipped << " of " << counts.empty << " empty cells\n";
            ASSERT_GT(counts.empty, 50U);
            EXPECT_GE(counts.skipped, counts.empty * (coarser == 0 ? 9U : 6U) / 10U);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    All,
    RealVolumeCells,
    testing::Values(
        Real{"fuel_68x68x68_u8.nrrd", true, 20},
        Real{"engine_256x256x128_u8.nrrd", false, 110},
        Real{"cranium_ct_256x256x108_i16.nrrd", false, 300}),
    [](const testing::TestParamInfo<Real>& each) {
        const std::string name = each.param.file;
        return name.substr(0, name.find('_'));
    });

} // namespace
} // namespace isofront::extractor
