#include "FieldChecks.h"

#include <isofront/fields/Procedural.h>

#include <glm/geometric.hpp>

namespace isofront::fields {
namespace {

using namespace test;

using Parameters = std::map<std::string, std::string>;

std::string errorOf(const std::string& name, const Parameters& parameters)
{
    const core::Result<ProceduralSource> source = makeProcedural(name, parameters);
    EXPECT_FALSE(source.has_value()) << name;
    if (source.has_value())
        return {};
    EXPECT_EQ(source.error().code, core::ErrorCode::usage);
    return source.error().message;
}

TEST(Procedural, tellsAllParametersInOneWayOfWriting)
{
    for (const ProceduralDescription& description : proceduralSources()) {
        Parameters defaults;
        for (const ProceduralParameter& parameter : description.parameters)
            defaults[parameter.name] = parameter.defaultValue;
        EXPECT_EQ(makeProcedural(description.name, {})->parameters, defaults) << description.name;
        EXPECT_EQ(makeProcedural(description.name, defaults)->parameters, defaults);
    }
    const auto box = [](const char* x) { return makeProcedural("box", {{"x", x}})->parameters; };
    EXPECT_EQ(box("2.50"), box("25e-1"));
    EXPECT_NE(box("2.5"), box("2.5000000000000004"));
    EXPECT_EQ(
        makeProcedural("plane", {{"x", "-0"}})->parameters,
        makeProcedural("plane", {{"x", "0"}})->parameters);
    EXPECT_EQ(makeProcedural("terrain", {{"seed", "07"}})->parameters.at("seed"), "7");
}

TEST(Procedural, makesEverySourceItListsWithItsDefaults)
{
    std::vector<std::string> names;
    for (const ProceduralDescription& description : proceduralSources()) {
        names.push_back(description.name);
        Parameters defaults;
        for (const ProceduralParameter& parameter : description.parameters)
            defaults[parameter.name] = parameter.defaultValue;
        const core::Result<ProceduralSource> made = makeProcedural(description.name, {});
        ASSERT_TRUE(made.has_value()) << made.error().message;
        ASSERT_TRUE(makeProcedural(description.name, defaults).has_value()) << description.name;
        EXPECT_FALSE(made->description.empty());
        const glm::dvec3 size = made->domain.size();
        EXPECT_EQ(size.x, size.y);
        EXPECT_EQ(size.x, size.z);
        EXPECT_GT(glm::length(made->target - made->eye), 0);
        EXPECT_LT(valueAt(*made->field, made->eye.x, made->eye.y, made->eye.z), 0)
            << description.name << ": the eye is inside the solid";
        // The surface is in the domain.
        Random random(41);
        const Points points = randomPoints(random, made->domain, 0, 20000);
        std::size_t solid = 0;
        for (const float value : valuesOf(*made->field, points.batch()))
            solid += double(value) >= made->isovalue ? 1U : 0U;
        EXPECT_GT(solid, 0U) << description.name;
        EXPECT_LT(solid, points.size()) << description.name;
    }
    EXPECT_EQ(
        names,
        (std::vector<std::string>{
            "terrain", "graph", "noise", "sphere", "torus", "box", "plane", "gyroid", "julia"}));
}

TEST(Procedural, takesParameters)
{
    const core::Result<ProceduralSource> source = makeProcedural("sphere", {{"radius", "3.5"}});
    ASSERT_TRUE(source.has_value());
    EXPECT_EQ(valueAt(*source->field, 0, 0, 0), 3.5F);

    const core::Result<ProceduralSource> terrain =
        makeProcedural("terrain", {{"preset", "canyon"}, {"seed", "7"}, {"filter", "0"}});
    ASSERT_TRUE(terrain.has_value());
    const glm::dvec3 p = terrain->target;
    EXPECT_EQ(
        valueAt(*terrain->field, p.x, p.y, p.z - 100, 0),
        valueAt(*terrain->field, p.x, p.y, p.z - 100, 50));
}

TEST(Procedural, makesEveryKindOfNoise)
{
    std::vector<std::vector<float>> all;
    for (const char* kind : {"value", "gradient", "simplex", "cellular", "border"})
        for (const char* fractal : {"brownian", "ridged", "billow"})
            for (const char* plane : {"0", "1"}) {
                const core::Result<ProceduralSource> source = makeProcedural(
                    "noise", {{"kind", kind}, {"fractal", fractal}, {"plane", plane}});
                ASSERT_TRUE(source.has_value());
                Random random(42);
                const Points points = randomPoints(random, {glm::dvec3(-2), glm::dvec3(2)}, 0, 200);
                all.push_back(valuesOf(*source->field, points.batch()));
            }
    // No two are the same.
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            EXPECT_GT(differingBits(all[i], all[k]), 150U) << i << ", " << k;
}

TEST(Procedural, saysWhichSourcesThereAre)
{
    const std::string message = errorOf("cube", {});
    EXPECT_NE(message.find("'cube'"), std::string::npos) << message;
    EXPECT_NE(
        message.find("terrain, graph, noise, sphere, torus, box, plane, gyroid, julia"),
        std::string::npos)
        << message;
}

TEST(Procedural, saysWhichParametersThereAre)
{
    const std::string message = errorOf("torus", {{"radius", "1"}});
    EXPECT_NE(message.find("'radius'"), std::string::npos) << message;
    EXPECT_NE(message.find("ring, tube"), std::string::npos) << message;
}

TEST(Procedural, saysWhichValuesWillDo)
{
    const std::string preset = errorOf("terrain", {{"preset", "moon"}});
    EXPECT_NE(preset.find("alpine, canyon, islands, karst"), std::string::npos) << preset;
    const std::string number = errorOf("julia", {{"iterations", "41"}});
    EXPECT_NE(number.find("whole number from 1 to 40"), std::string::npos) << number;
}

TEST(Procedural, refusesWhatIsNoNumberInRange)
{
    for (const char* text :
         {"",
          " ",
          "1 ",
          " 1",
          "one",
          "nan",
          "inf",
          "-inf",
          "1e999",
          "0x10",
          "1,5",
          "-1",
          "0",
          "++1"})
        EXPECT_FALSE(errorOf("sphere", {{"radius", text}}).empty()) << text;
    EXPECT_FALSE(errorOf("terrain", {{"seed", "1.5"}}).empty());
    EXPECT_FALSE(errorOf("terrain", {{"seed", "-1"}}).empty());
    EXPECT_FALSE(errorOf("sphere", {{"radius", std::string("1\0", 2)}}).empty());
}

} // namespace
} // namespace isofront::fields
