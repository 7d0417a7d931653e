// How fast noise is, on one thread, for each instruction set: at scattered points, there together
// with its gradient, and on a grid; beside what the machine can do at most in the same run.

#include "Suites.h"
#include "isofront/bench/Timing.h"

#include <isofront/core/Hash.h>
#include <isofront/fields/Graph.h>
#include <isofront/fields/Noise.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace isofront::bench {

namespace {

using fields::FractalKind;
using fields::NoiseKind;
using fields::NoiseSettings;

Table rateTable()
{
    Table table{
        "rates",
        "Noise, one thread: samples a second by instruction set",
        {{"set", "", "instruction set, as Highway names it"},
         {"fma", "GFLOP/s", "multiply-adds that the machine does with it, in the same run"},
         {"noise", "", "kind and number of octaves, unfiltered; graph: the same as a node, less z"},
         {"points", "", "scattered: 16384 points; grid: 128 x 128 x 32, longest wave 64 steps"},
         {"rate", "Ms/s", "samples a second, processor time, the best of the runs"},
         {"per_fma", "Ms/GFLOP", "rate over fma"},
         {"relative", "", "rate over that of the scattered value"},
         {"spread", "%", "of the runs"},
         {"runs", "", "timed runs"},
         {"checksum", "", "of the values' bits"}},
        {},
        {}};
    table.plots.push_back(
        {.name = "fractal",
         .title = "Six octaves of gradient noise",
         .x = "fma",
         .y = "rate",
         .series = "points",
         .whereColumn = "noise",
         .whereWord = "gradient x 6",
         .isLogarithmicX = true,
         .isLogarithmicY = true,
         .guides = {1.0}});
    return table;
}

struct Kind {
    NoiseKind kind;
    const char* name;
};
constexpr std::array<Kind, 5> kKinds{
    {{NoiseKind::gradient, "gradient"},
     {NoiseKind::value, "value"},
     {NoiseKind::simplex, "simplex"},
     {NoiseKind::cellular, "cellular"},
     {NoiseKind::border, "border"}}};

/// Points within a cube, the same on every machine, and room for what is found there.
struct Scattered {
    std::vector<double> x, y, z;
    std::vector<float> values;
    std::vector<double> gx, gy, gz;

    explicit Scattered(std::size_t count) : values(count), gx(count), gy(count), gz(count)
    {
        constexpr double kEdge = 1000; // about sixteen of the longest waves
        const auto coordinate = [](std::uint64_t i) {
            return kEdge * static_cast<double>(core::mixed(i) >> 11U) * 0x1p-53;
        };
        for (std::uint64_t i = 0; i < count; ++i) {
            x.push_back(coordinate(3 * i + 1));
            y.push_back(coordinate(3 * i + 2));
            z.push_back(coordinate(3 * i + 3));
        }
    }
    [[nodiscard]] fields::SampleBatch batch() const { return {x, y, z}; }
};

std::uint64_t checksumOf(std::span<const float> values)
{
    std::uint64_t hash = 0;
    for (const float value : values)
        hash = core::hashCombined(hash, std::bit_cast<std::uint32_t>(value));
    return hash;
}

std::string hexadecimal(std::uint64_t value)
{
    std::array<char, 20> text{};
    (void)std::snprintf(
        text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
    return text.data();
}

struct Measured {
    Timing timing;
    std::size_t samples = 0;
    std::uint64_t checksum = 0;

    [[nodiscard]] double rate() const
    {
        return timing.least > 0 ? double(samples) / timing.least * 1e-6
                                : std::numeric_limits<double>::quiet_NaN();
    }
};

class NoiseBench {
public:
    explicit NoiseBench(const Context& context)
        : _context(context), _points(16384), _grid{.spacing = 1, .count = {128, 128, 32}},
          _gridValues(_grid.size())
    {
        _result.tables.push_back(rateTable());
    }

    SuiteResult run()
    {
        bool isBest = true;
        for (const FmaRate& rate : fmaRates()) {
            if (_context.isStopped())
                break;
            _context.say("noise with " + rate.instructionSet);
            _set = rate.instructionSet;
            _fma = rate.gigaflops;
            withInstructionSet(rate.instructionSet, [&] {
                measureFractal();
                // The single kinds on the best set only, unless there is time.
                if (_context.isFull() || isBest)
                    measureKinds();
            });
            isBest = false;
        }
        _result.check(
            "every instruction set gives the same bits", _allSame, "checksums of the values");
        _result.check(
            "the grid gives what single samples give, to 1e-5",
            _worstOnGrid < 1e-5,
            "they differ by " + std::to_string(_worstOnGrid));
        return std::move(_result);
    }

private:
    [[nodiscard]] std::size_t runs() const { return _context.pick<std::size_t>(7, 25); }

    static NoiseSettings settingsOf(NoiseKind kind, int octaves)
    {
        NoiseSettings settings;
        settings.kind = kind;
        settings.wavelength = 64;
        settings.octaves = octaves;
        return settings;
    }

    void measureFractal()
    {
        const std::shared_ptr<const fields::Field> field =
            fields::fractalNoise(settingsOf(NoiseKind::gradient, 6));
        const Measured value = atPoints(*field);
        add("gradient x 6", "scattered", value, value);
        const Measured gradient = withGradient(*field);
        add("gradient x 6", "scattered, with gradient", gradient, value);
        same("scattered", value.checksum);
        same("scattered", gradient.checksum);
        const Measured grid = onGrid(*field);
        add("gradient x 6", "grid", grid, value);
        same("grid", grid.checksum);
        _worstOnGrid = std::max(_worstOnGrid, worstOnGrid(*field));
        measureGraph();
    }

    void measureGraph()
    {
        namespace graph = fields::graph;
        const std::shared_ptr<const fields::Field> field = graph::graphField(
            graph::noise({.wavelength = 64, .octaves = 6, .lacunarity = 2}) -
            graph::position(graph::Axis::z));
        const Measured value = atPoints(*field);
        add("graph x 6", "scattered", value, value);
        const Measured grid = onGrid(*field);
        add("graph x 6", "grid", grid, value);
        same("graph", value.checksum);
        same("graph grid", grid.checksum);
        _worstOnGrid = std::max(_worstOnGrid, worstOnGrid(*field));
    }

    void measureKinds()
    {
        for (const Kind& kind : kKinds) {
            const std::shared_ptr<const fields::Field> field =
                fields::fractalNoise(settingsOf(kind.kind, 1));
            const std::string name = std::string(kind.name) + " x 1";
            const Measured value = atPoints(*field);
            add(name, "scattered", value, value);
            add(name, "scattered, with gradient", withGradient(*field), value);
            add(name, "grid", onGrid(*field), value);
            same(name, value.checksum);
        }
    }

    Measured atPoints(const fields::Field& field)
    {
        const Timing timing = timed([&] { field.sample(_points.batch(), _points.values); }, runs());
        return {timing, _points.values.size(), checksumOf(_points.values)};
    }

    Measured withGradient(const fields::Field& field)
    {
        const Timing timing = timed(
            [&] {
                field.sampleWithGradient(
                    _points.batch(), _points.values, {_points.gx, _points.gy, _points.gz});
            },
            runs());
        return {timing, _points.values.size(), checksumOf(_points.values)};
    }

    Measured onGrid(const fields::Field& field)
    {
        const Timing timing = timed([&] { field.sampleGrid(_grid, _gridValues); }, runs());
        return {timing, _gridValues.size(), checksumOf(_gridValues)};
    }

    /// The most by which the grid's values differ from those of single samples, in the last slice.
    double worstOnGrid(const fields::Field& field) const
    {
        const auto row = static_cast<std::size_t>(_grid.count.x);
        const std::size_t begin = _grid.size() - row * static_cast<std::size_t>(_grid.count.y);
        std::vector<double> x(row);
        std::vector<double> y(row);
        const std::vector<double> z(row, _grid.spacing * double(_grid.count.z - 1));
        for (std::size_t i = 0; i < row; ++i)
            x[i] = _grid.spacing * double(i);
        std::vector<float> values(row);
        double worst = 0;
        for (std::int64_t j = 0; j < _grid.count.y; ++j) {
            std::ranges::fill(y, _grid.spacing * double(j));
            field.sample({x, y, z}, values);
            for (std::size_t i = 0; i < row; ++i)
                worst = std::max(
                    worst,
                    std::abs(
                        double(values[i]) -
                        double(_gridValues[begin + static_cast<std::size_t>(j) * row + i])));
        }
        return worst;
    }

    /// Compares with what another instruction set has given under the same name.
    void same(const std::string& name, std::uint64_t checksum)
    {
        const auto known = std::ranges::find(_checksums, name, &NamedChecksum::name);
        if (known == _checksums.end())
            _checksums.push_back({name, checksum});
        else
            _allSame = _allSame && known->checksum == checksum;
    }

    void
    add(const std::string& noise,
        const std::string& points,
        const Measured& measured,
        const Measured& scattered)
    {
        _result.tables[0].add(
            {_set,
             _fma,
             noise,
             points,
             measured.rate(),
             measured.rate() / _fma,
             measured.rate() / scattered.rate(),
             100 * measured.timing.spread,
             count(measured.timing.runs),
             hexadecimal(measured.checksum)});
    }

    struct NamedChecksum {
        std::string name;
        std::uint64_t checksum;
    };

    const Context& _context;
    Scattered _points;
    fields::SampleGrid _grid;
    std::vector<float> _gridValues;
    SuiteResult _result;
    std::string _set;
    double _fma = 0;
    std::vector<NamedChecksum> _checksums;
    bool _allSame = true;
    double _worstOnGrid = 0;
};

} // namespace

SuiteResult runNoise(const Context& context)
{
    return NoiseBench(context).run();
}

} // namespace isofront::bench
