#include "TilesetReader.h"
#include "exchange/ExchangeFixture.h"

#include <isofront/fields/Shapes.h>
#include <isofront/tiles/Tileset.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace isofront::tiles::test {

class TilesetValidatorTest : public exchange::test::ExchangeTest {};

TEST_F(TilesetValidatorTest, findsNoErrorAndNoWarningInAnyTile)
{
    const std::filesystem::path validator = ISOFRONT_VALIDATOR_DIR;
    ASSERT_TRUE(std::filesystem::exists(ISOFRONT_NODE)) << "install nodejs and configure again";
    ASSERT_TRUE(std::filesystem::exists(validator / "node_modules" / "gltf-validator"))
        << "install the validator: (cd " << validator << " && npm ci)";
    hierarchy::Domain domain;
    domain.worldFromField.translation = {4.1e6, 6e5, 4.8e6}; // as on the earth
    extractor::ExtractionSettings settings;
    settings.latticeSize = 4;
    TilesetOptions options;
    options.levels = 3;
    options.tileSteps = 8;
    options.name = "a \"ball\"\n\xff";
    const auto jobs = core::makeJobs();
    const auto report = writeTileset(
        fields::sphere({0.5, 0.45, 0.55}, 0.3), domain, settings, *jobs, options, path("tiles"));
    ASSERT_TRUE(report) << report.error().message;
    std::string command =
        std::string(ISOFRONT_NODE) + " '" + (validator / "validate.cjs").string() + "'";
    const ReadTile root = readTileset(path("tiles"));
    for (const ReadTile* tile : allOf(root))
        command += " '" + (path("tiles") / tile->uri).string() + "'";
    command += " >'" + path("output").string() + "' 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << exchange::test::contentOf(path("output"));
}

} // namespace isofront::tiles::test
