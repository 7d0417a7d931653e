#include "../FieldChecks.h"

#include <isofront/fields/Graph.h>
#include <isofront/fields/Noise.h>
#include <isofront/fields/Shapes.h>

#include <functional>
#include <numeric>

namespace isofront::fields::graph {
namespace {

using namespace test;

core::Box cube(double half)
{
    return {glm::dvec3(-half), glm::dvec3(half)};
}

const OctaveSettings kHills{
    .wavelength = 40, .octaves = 5, .amplitude = 9, .plane = true, .seed = 3};
const OctaveSettings kRocks{
    .wavelength = 17, .octaves = 4, .amplitude = 3, .stretch = 1.5, .seed = 4};

const OctaveSettings kRidges{
    .fractal = FractalKind::ridged,
    .wavelength = 40,
    .octaves = 5,
    .amplitude = 9,
    .carry = 3,
    .plane = true,
    .seed = 3};
const OctaveSettings kCrests{
    .fractal = FractalKind::ridged, .wavelength = 17, .octaves = 4, .amplitude = 3, .seed = 4};

/// Two octaves of a kind of noise.
Node ofKind(NoiseKind kind, FractalKind fractal, bool plane)
{
    return noise(
        {.kind = kind,
         .fractal = fractal,
         .wavelength = 13,
         .octaves = 2,
         .amplitude = 4,
         .plane = plane});
}

Node ground()
{
    return noise(kHills) - position(Axis::z);
}

// ---- Every kind of node -------------------------------------------------------------------------

struct Example {
    const char* name;
    std::function<Node()> make;
};
void PrintTo(const Example& example, std::ostream* stream)
{
    *stream << example.name;
}

const std::vector<CurvePoint> kSteps{{-6, -5}, {-1, -2}, {0, 3}, {2, 3.5}, {7, 1}};

class EveryNode : public testing::TestWithParam<Example> {
protected:
    [[nodiscard]] static std::shared_ptr<const Field> make()
    {
        return graphField(GetParam().make(), {.seed = 5});
    }
};

INSTANTIATE_TEST_SUITE_P(
    Graph,
    EveryNode,
    testing::Values(
        Example{"constant", [] { return Node(2.5); }},
        Example{"position", [] { return position(Axis::y); }},
        Example{"filterWeight", [] { return filterWeight(3.0) * position(Axis::x); }},
        Example{"fractalInThePlane", [] { return noise(kHills); }},
        Example{"fractalInSpace", [] { return noise(kRocks); }},
        Example{
            "unfilteredFractal",
            [] { return noise({.wavelength = 9, .octaves = 3, .filtered = false}); }},
        Example{"ridgesInThePlane", [] { return noise(kRidges); }},
        Example{"ridgesInSpace", [] { return noise(kCrests); }},
        Example{"valueNoise", [] { return ofKind(NoiseKind::value, FractalKind::billow, false); }},
        Example{
            "valueNoiseInThePlane",
            [] { return ofKind(NoiseKind::value, FractalKind::brownian, true); }},
        Example{
            "simplexNoise",
            [] { return ofKind(NoiseKind::simplex, FractalKind::brownian, false); }},
        Example{
            "simplexNoiseInThePlane",
            [] { return ofKind(NoiseKind::simplex, FractalKind::ridged, true); }},
        Example{
            "cellularNoise",
            [] { return ofKind(NoiseKind::cellular, FractalKind::brownian, false); }},
        Example{
            "cellularNoiseInThePlane",
            [] { return ofKind(NoiseKind::cellular, FractalKind::billow, true); }},
        Example{
            "borderNoise", [] { return ofKind(NoiseKind::border, FractalKind::brownian, false); }},
        Example{
            "borderNoiseInThePlane",
            [] { return ofKind(NoiseKind::border, FractalKind::brownian, true); }},
        Example{
            "detailOfCells",
            [] {
                const OctaveSettings layers[1] = {
                    {.kind = NoiseKind::cellular, .wavelength = 9, .octaves = 2, .seed = 6}};
                return detail(ground(), layers);
            }},
        Example{"source", [] { return source(fractalNoise({.seed = 3, .wavelength = 11})) * 2.0; }},
        Example{
            "sourceThatIsAGraph",
            [] { return ground() + source(graphField(noise(kRocks) + 0.5, {.seed = 8})); }},
        Example{"sum", [] { return noise(kHills) + noise(kRocks); }},
        Example{"difference", [] { return ground(); }},
        Example{"product", [] { return noise(kHills) * noise(kRocks); }},
        Example{
            "productWithAFactorThatIsOftenZero",
            [] { return smoothStep(noise(kHills), 1, 3) * noise(kRocks); }},
        Example{"negation", [] { return -noise(kRocks) * 3.0 + 1.0; }},
        Example{"abs", [] { return abs(noise(kRocks)); }},
        Example{"square", [] { return square(noise(kRocks)); }},
        Example{"sqrt", [] { return sqrt(noise(kRocks)); }},
        Example{"min", [] { return min(ground(), noise(kRocks)); }},
        Example{"max", [] { return max(ground(), noise(kRocks)); }},
        Example{"smoothMin", [] { return smoothMin(ground(), noise(kRocks) * 2.0, 3); }},
        Example{"smoothMax", [] { return smoothMax(noise(kRocks) - 1.0, ground(), 3); }},
        Example{"clamp", [] { return clamp(ground(), -3, 5); }},
        Example{"smoothStep", [] { return smoothStep(ground(), -3, 5) * 8.0; }},
        Example{
            "mix",
            [] { return mix(ground(), noise(kRocks), smoothStep(position(Axis::x), -20, 20)); }},
        Example{"curve", [] { return curve(noise(kHills), kSteps); }},
        Example{"distance", [] { return 20.0 - distance(3, -4, 5); }},
        Example{
            "warp", [] { return warp(ground(), noise(kRocks), noise(kHills) * 0.5, 0.0, 1.4); }},
        Example{
            "warpWithinAWarp",
            [] {
                return warp(
                    warp(noise(kHills), noise(kRocks), 0.0, 0.0) - position(Axis::z),
                    0.0,
                    0.0,
                    noise(kRocks));
            }},
        Example{"placed", [] { return placed(ground(), 5, -3, 2, 1.7); }},
        Example{
            "detail",
            [] {
                const OctaveSettings layers[2] = {
                    kRocks, {.wavelength = 5, .octaves = 3, .seed = 6}};
                return detail(ground(), layers, smoothStep(noise(kHills), -2, 2), 0.5);
            }},
        Example{
            "tunnels",
            [] {
                return tunnels(
                    ground(), {.wavelength = 30, .radius = 3, .depth = 15, .rounding = 1});
            }}),
    [](const testing::TestParamInfo<Example>& instance) { return instance.param.name; });

TEST_P(EveryNode, givesTheSameBitsOnEveryInstructionSet)
{
    const std::shared_ptr<const Field> field = make();
    Random random(71);
    const Points points = randomPoints(random, cube(60), 4.0, 3001);
    const std::vector<float> values = valuesOf(*field, points.batch());
    const Gradients gradients = gradientsOf(*field, points.batch());
    const core::Box box{glm::dvec3(1, -2, -3), glm::dvec3(4, 5, 2)};
    const core::Interval bounds = field->bounds(box, {0.1, 2});
    onEveryInstructionSet([&](const std::string& name) {
        EXPECT_EQ(differingBits(valuesOf(*field, points.batch()), values), 0U) << name;
        const Gradients other = gradientsOf(*field, points.batch());
        EXPECT_EQ(other.x, gradients.x) << name;
        EXPECT_EQ(other.y, gradients.y) << name;
        EXPECT_EQ(other.z, gradients.z) << name;
        const core::Interval again = field->bounds(box, {0.1, 2});
        EXPECT_EQ(again.low, bounds.low) << name;
        EXPECT_EQ(again.high, bounds.high) << name;
    });
}

TEST_P(EveryNode, givesTheSameBitsWhereverAPointStandsInItsBatch)
{
    const std::shared_ptr<const Field> field = make();
    Random random(72);
    expectSameBitsAnywhereInABatch(*field, randomPoints(random, cube(60), 4.0, 64));
}

TEST_P(EveryNode, givesValueAndGradientTogetherAsOneByOne)
{
    const std::shared_ptr<const Field> field = make();
    Random random(73);
    const Points points = randomPoints(random, cube(60), 4.0, 2000);
    std::vector<float> values(points.size());
    Gradients gradients = gradientsOf(*field, points.batch());
    const Gradients alone = gradients;
    field->sampleWithGradient(points.batch(), values, {gradients.x, gradients.y, gradients.z});
    EXPECT_EQ(differingBits(values, valuesOf(*field, points.batch())), 0U);
    EXPECT_EQ(gradients.x, alone.x);
    EXPECT_EQ(gradients.y, alone.y);
    EXPECT_EQ(gradients.z, alone.z);
}

TEST_P(EveryNode, hasGradientsThatMatchDifferences)
{
    const std::shared_ptr<const Field> field = make();
    Random random(74);
    Points points = randomPoints(random, cube(60), 4.0, 1500);
    // Creases and the root's infinite slope are hit now and then.
    expectGradientsMatchDifferences(*field, points, 0.004, 0.03, 0.03);
}

TEST_P(EveryNode, staysWithinItsBounds)
{
    const std::shared_ptr<const Field> field = make();
    expectBoundsHold(*field, cube(60), 6.0, 1000, 100, 75);
    // Far out coordinates are rounded to whole units in float.
    const core::Box far{
        glm::dvec3(1e8 - 50, -1e8, 3e7), glm::dvec3(1e8 + 50, -1e8 + 100, 3e7 + 100)};
    expectBoundsHold(*field, far, 6.0, 200, 50, 76);
}

TEST_P(EveryNode, isTightOnAPoint)
{
    // Bounds of a box without extent differ from the value by little more than rounding.
    const std::shared_ptr<const Field> field = make();
    Random random(77);
    const Points points = randomPoints(random, cube(60), 0.0, 200);
    const std::vector<float> values = valuesOf(*field, points.batch());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::dvec3 p(points.x[i], points.y[i], points.z[i]);
        const core::Interval bounds = field->bounds({p, p}, {0, 0});
        EXPECT_TRUE(bounds.contains(double(values[i])));
        EXPECT_LT(bounds.high - bounds.low, 0.02 + 0.01 * std::abs(double(values[i])));
    }
}

// ---- Against formulas of its own ----------------------------------------------------------------

TEST(Graph, equalsAFormulaWrittenOutInDouble)
{
    const double width = 2.5;
    const Node x = position(Axis::x);
    const Node y = position(Axis::y);
    const Node z = position(Axis::z);
    const Node node = smoothMax(
        min(abs(x) * 0.5 - y, square(y) * 0.25 + 1.0),
        mix(z, clamp(x * y, -4, 3), smoothStep(z, -1, 2)),
        width);
    const auto formula = [&](double px, double py, double pz) {
        const double a = std::min(std::abs(px) * 0.5 - py, py * py * 0.25 + 1.0);
        const double s = std::clamp((pz + 1) / 3, 0.0, 1.0);
        const double t = s * s * (3 - 2 * s);
        const double b = pz + t * (std::clamp(px * py, -4.0, 3.0) - pz);
        const double h = std::max(0.0, width - std::abs(a - b));
        return std::max(a, b) + 0.25 / width * h * h;
    };
    const std::shared_ptr<const Field> field = graphField(node);
    Random random(81);
    const Points points = randomPoints(random, cube(8), 0, 5000);
    const std::vector<float> values = valuesOf(*field, points.batch());
    for (std::size_t i = 0; i < points.size(); ++i)
        ASSERT_NEAR(double(values[i]), formula(points.x[i], points.y[i], points.z[i]), 1e-5);
}

TEST(Graph, drawsACurveThroughItsPointsWithoutOvershooting)
{
    const std::shared_ptr<const Field> field = graphField(curve(position(Axis::x), kSteps));
    for (const CurvePoint& point : kSteps)
        EXPECT_EQ(valueAt(*field, point.at, 0, 0), static_cast<float>(point.value));
    EXPECT_EQ(valueAt(*field, -100, 0, 0), -5.0F);
    EXPECT_EQ(valueAt(*field, 100, 0, 0), 1.0F);
    // Rising to the last point but one, then falling.
    float before = -5;
    for (double x = -6; x < 2; x += 0.001) {
        const float value = valueAt(*field, x, 0, 0);
        ASSERT_GE(value, before - 1e-6F) << x;
        before = value;
    }
    for (double x = 2; x < 7; x += 0.001) {
        const float value = valueAt(*field, x, 0, 0);
        ASSERT_LE(value, before + 1e-6F) << x;
        before = value;
    }
}

TEST(Graph, weighsOctavesByTheFilter)
{
    // One octave: the value at radius r is the unfiltered one times exp(-(kappa f r)^2), to within
    // the 1.3e-4 that docs/numerics.md allows.
    const double wavelength = 12;
    const double kappa = 1.3;
    const std::shared_ptr<const Field> field = graphField(
        noise({.wavelength = wavelength, .amplitude = 1, .seed = 2}),
        {.seed = 1, .filterStrength = kappa});
    Random random(82);
    for (int i = 0; i < 300; ++i) {
        const double x = random(-50, 50);
        const double y = random(-50, 50);
        const double z = random(-50, 50);
        const double r = random(0, 40);
        const double cycles = kappa * r / wavelength;
        const double weight = cycles < 3 ? std::exp(-cycles * cycles) : 0.0;
        ASSERT_NEAR(
            double(valueAt(*field, x, y, z, r)),
            weight * double(valueAt(*field, x, y, z, 0)),
            1.5e-4)
            << r;
    }
}

TEST(Graph, scalesTheFilterRadiusWithinWarpsAndPlacements)
{
    const OctaveSettings octave{.wavelength = 10, .amplitude = 2, .seed = 2};
    const std::shared_ptr<const Field> plain = graphField(noise(octave));
    const std::shared_ptr<const Field> warped = graphField(warp(noise(octave), 0.0, 0.0, 0.0, 2.0));
    const std::shared_ptr<const Field> large = graphField(placed(noise(octave), 1, 2, 3, 4.0));
    Random random(83);
    for (int i = 0; i < 200; ++i) {
        const double x = random(-50, 50);
        const double y = random(-50, 50);
        const double z = random(-50, 50);
        const double r = random(0, 12);
        EXPECT_EQ(valueAt(*warped, x, y, z, r), valueAt(*plain, x, y, z, 2 * r));
        EXPECT_NEAR(
            valueAt(*large, 4 * x + 1, 4 * y + 2, 4 * z + 3, 4 * r),
            valueAt(*plain, x, y, z, r),
            1e-5F);
    }
}

TEST(Graph, isTheSameTenThousandKilometresOut)
{
    // Moved by a whole number of metres the graph is the same graph: places are found in double.
    const double far = 1e7;
    const OctaveSettings fine{.wavelength = 0.01, .octaves = 3, .amplitude = 1, .seed = 9};
    const std::shared_ptr<const Field> field = graphField(noise(fine));
    const std::shared_ptr<const Field> moved = graphField(placed(noise(fine), far, -far, far));
    Random random(84);
    for (int i = 0; i < 500; ++i) {
        // Multiples of 2^-20 keep the sum exact.
        const double x = std::round(random(-1, 1) * 0x1p20) * 0x1p-20;
        const double y = std::round(random(-1, 1) * 0x1p20) * 0x1p-20;
        const double z = std::round(random(-1, 1) * 0x1p20) * 0x1p-20;
        EXPECT_EQ(valueAt(*moved, far + x, y - far, far + z), valueAt(*field, x, y, z));
    }
}

TEST(Graph, hasOtherNoiseForEverySeed)
{
    const auto make = [](std::uint64_t graphSeed, std::uint64_t seed) {
        return graphField(noise({.wavelength = 3, .seed = seed}), {.seed = graphSeed});
    };
    Random random(85);
    const Points points = randomPoints(random, cube(50), 0, 500);
    const std::vector<float> first = valuesOf(*make(1, 1), points.batch());
    EXPECT_EQ(differingBits(first, valuesOf(*make(1, 1), points.batch())), 0U);
    EXPECT_GT(differingBits(first, valuesOf(*make(2, 1), points.batch())), 480U);
    EXPECT_GT(differingBits(first, valuesOf(*make(1, 2), points.batch())), 480U);
}

// ---- What is left out ---------------------------------------------------------------------------

/// Counts the points that it is asked for.
class Counting final : public Field {
public:
    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        asked += batch.size();
        std::ranges::fill(values, 1.0F);
    }
    core::Interval bounds(const core::Box&, core::Interval) const override { return {1, 1}; }
    double differenceStep(double) const override { return 1; }

    mutable std::size_t asked = 0;
};

std::size_t askedOf(const std::function<Node(const Node&)>& around, const core::Box& box)
{
    const auto counting = std::make_shared<Counting>();
    const std::shared_ptr<const Field> field = graphField(around(source(counting)));
    Random random(86);
    valuesOf(*field, randomPoints(random, box, 0, 512).batch());
    return counting->asked;
}

TEST(Graph, leavesOutWhatCannotMatter)
{
    const core::Box box{glm::dvec3(10), glm::dvec3(20)};
    const Node x = position(Axis::x);
    const auto within = [](const Node& node) { return clamp(node, -3, 4); };
    // Far below and above all that the other input can be.
    EXPECT_EQ(askedOf([&](const Node& s) { return max(x, within(s)); }, box), 0U);
    EXPECT_EQ(askedOf([&](const Node& s) { return max(within(s), x); }, box), 0U);
    EXPECT_EQ(askedOf([&](const Node& s) { return min(-x, within(s)); }, box), 0U);
    EXPECT_EQ(askedOf([&](const Node& s) { return smoothMax(x, within(s), 5); }, box), 0U);
    EXPECT_EQ(askedOf([&](const Node& s) { return smoothStep(x, 30, 40) * s; }, box), 0U);
    // One within the other.
    EXPECT_EQ(
        askedOf([&](const Node& s) { return max(x, within(smoothStep(x, 0, 40) * s)); }, box), 0U);
    // Where it can matter, and where it is needed for something else as well.
    EXPECT_EQ(askedOf([&](const Node& s) { return min(x, within(s)); }, box), 512U);
    EXPECT_EQ(askedOf([&](const Node& s) { return max(x, within(s)) + s; }, box), 512U);
    EXPECT_EQ(askedOf([&](const Node& s) { return smoothMax(x, within(s), 30); }, box), 512U);
}

TEST(Graph, computesOnceWhatIsUsedTwice)
{
    const core::Box box{glm::dvec3(10), glm::dvec3(20)};
    EXPECT_EQ(askedOf([](const Node& s) { return s * s + s; }, box), 512U);
    // A chain of doublings has 2^60 paths, and sixty nodes.
    EXPECT_EQ(
        askedOf(
            [](const Node& s) {
                Node sum = s * 0x1p-60;
                for (int i = 0; i < 60; ++i)
                    sum = sum + sum;
                return sum;
            },
            box),
        512U);
}

/// Graphs put together at random; their values written out by a second, plain evaluation.
class RandomGraph {
public:
    explicit RandomGraph(std::uint64_t seed) : _random(seed) {}

    using Twin = std::function<double(double, double, double)>;
    struct Pair {
        Node node;
        Twin twin;
    };

    Pair make(int depth)
    {
        if (depth == 0)
            return leaf();
        const Pair a = make(depth - 1);
        const auto pick = static_cast<int>(_random(0, 9));
        if (pick == 0)
            return {abs(a.node), [f = a.twin](double x, double y, double z) {
                        return std::abs(f(x, y, z));
                    }};
        if (pick == 1) {
            const double s = _random(-2, 2);
            const double o = _random(-5, 5);
            return {a.node * s + o, [=, f = a.twin](double x, double y, double z) {
                        return f(x, y, z) * s + o;
                    }};
        }
        if (pick == 2) {
            const double low = _random(-5, 0);
            const double high = _random(0, 5);
            return {clamp(a.node, low, high), [=, f = a.twin](double x, double y, double z) {
                        return std::clamp(f(x, y, z), low, high);
                    }};
        }
        if (pick == 3)
            return {smoothStep(a.node, -1, 2), [f = a.twin](double x, double y, double z) {
                        const double t = std::clamp((f(x, y, z) + 1) / 3, 0.0, 1.0);
                        return t * t * (3 - 2 * t);
                    }};
        // Half of the time something that has been there before.
        const Pair b =
            !_made.empty() && _random(0, 1) < 0.5
                ? _made[static_cast<std::size_t>(_random(0, double(_made.size()) - 1e-9))]
                : make(depth - 1);
        const Pair result = joined(pick, a, b);
        _made.push_back(result);
        return result;
    }

private:
    Pair leaf()
    {
        const double factor = _random(-3, 3);
        switch (static_cast<int>(_random(0, 3))) {
        case 0:
            return {
                position(Axis::x) * factor, [=](double x, double, double) { return factor * x; }};
        case 1:
            return {
                position(Axis::y) * factor, [=](double, double y, double) { return factor * y; }};
        default:
            return {
                position(Axis::z) * factor, [=](double, double, double z) { return factor * z; }};
        }
    }

    Pair joined(int pick, const Pair& a, const Pair& b)
    {
        const auto with = [&](const Node& node, auto operation) {
            return Pair{node, [f = a.twin, g = b.twin, operation](double x, double y, double z) {
                            return operation(f(x, y, z), g(x, y, z));
                        }};
        };
        switch (pick) {
        case 4:
            return with(a.node + b.node, [](double u, double v) { return u + v; });
        case 5:
            return with(a.node - b.node, [](double u, double v) { return u - v; });
        case 6:
            return with(smoothStep(a.node, 0, 1) * b.node, [](double u, double v) {
                const double t = std::clamp(u, 0.0, 1.0);
                return t * t * (3 - 2 * t) * v;
            });
        case 7:
            return with(min(a.node, b.node), [](double u, double v) { return std::min(u, v); });
        default:
            return with(smoothMax(a.node, b.node, 2.0), [](double u, double v) {
                const double h = std::max(0.0, 2.0 - std::abs(u - v));
                return std::max(u, v) + 0.125 * h * h;
            });
        }
    }

    Random _random;
    std::vector<Pair> _made;
};

TEST(Graph, equalsAPlainEvaluationForRandomGraphs)
{
    for (std::uint64_t seed = 1; seed <= 150; ++seed) {
        const RandomGraph::Pair pair = RandomGraph(seed).make(6);
        const std::shared_ptr<const Field> field = graphField(pair.node);
        Random random(seed);
        const Points points = randomPoints(random, cube(4), 0, 97);
        const std::vector<float> values = valuesOf(*field, points.batch());
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double expected = pair.twin(points.x[i], points.y[i], points.z[i]);
            ASSERT_NEAR(double(values[i]), expected, 2e-4 * (1 + std::abs(expected)))
                << "graph " << seed;
        }
        expectBoundsHold(*field, cube(4), 0, 20, 20, seed);
    }
}

} // namespace
} // namespace isofront::fields::graph
