#pragma once

#include "Octaves.h"
#include "graph/NodeData.h"
#include "isofront/fields/Field.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace isofront::fields::graph {

/// A lane of a guard's input is decided if ...
enum class Test : std::uint8_t {
    below,  ///< it is below the threshold
    above,  ///< it is above the threshold
    beyond, ///< its magnitude is above the threshold
    zero,   ///< it is zero, with its slope
};

/// One step of a program. Registers hold a number for each point of a block.
///
/// Work is left out like this: `guard` looks at one input of an operation; where that decides the
/// result alone it stores the result. Groups of lanes in which all lanes are decided sit out the
/// instructions from there to `end`: those that only the other input needs, the operation, and
/// `keep`, which stores the decided result once more in those lanes that were decided but whose
/// group was not. So a lane's result never depends on its neighbours.
struct Instruction {
    Op op = Op::constant;
    Test test = Test::below; ///< of guard and keep
    std::uint8_t axis = 0;   ///< of position
    bool plane = false;      ///< the octaves are in the plane
    NoiseKind kind = NoiseKind::gradient;
    FractalKind fractal = FractalKind::brownian;
    FractalNorms norms = {};
    std::uint32_t target = 0; ///< register, or frame
    std::uint32_t a = 0;      ///< registers
    std::uint32_t b = 0;
    std::uint32_t c = 0;
    std::uint32_t frame = 0; ///< where position, noise and sources are taken; the parent of a frame
    std::uint32_t first = 0; ///< index in the program's table
    std::uint32_t count = 0;
    std::uint32_t end = 0; ///< of a guard: the instruction behind its section
    float numbers[3] = {};
    float slack = 0; ///< what rounding can add to a result, on top of a few units in its last place
    double places[4] = {}; ///< of frames
};

/// Octaves of detail, and what is still to come.
struct DetailOctave {
    SpaceOctave noise;
    NoiseKind kind;
    /// The most by which this octave and all later ones can move a value.
    float remaining;
};

/// A piece of a curve, from `begin` on: a cubic in (x - begin).
struct CurvePiece {
    float begin;
    float coefficients[4];
    /// Least and most between here and the next piece.
    float low;
    float high;
};

/// A graph in the order in which it is evaluated; the result is in register 0 in the end.
struct Program {
    std::vector<Instruction> instructions;
    std::vector<SpaceOctave> spaceOctaves;
    std::vector<PlaneOctave> planeOctaves;
    std::vector<DetailOctave> detailOctaves;
    std::vector<CurvePiece> curvePieces;
    std::vector<std::shared_ptr<const Field>> sources;
    std::uint32_t registers = 0;
    std::uint32_t frames = 1; ///< frame 0 is the world
    std::uint32_t result = 0; ///< register
    double shortest = 0;      ///< wavelength in the program [field]; 0 if it has no noise
};

/// How many guards may lie within one another.
inline constexpr std::size_t kDeepestGuards = 32;

Program compiled(const Node& node, const GraphSettings& settings);

void sampleProgram(const Program& program, const SampleBatch& batch, std::span<float> values);
/// As `sampleProgram` at the points of the grid, but for rounding; what they have in common is
/// computed once.
/// @param grid  not empty
void gridProgram(const Program& program, const SampleGrid& grid, std::span<float> values);
void gradientProgram(
    const Program& program, const SampleBatch& batch, const GradientSpans& gradients);
void sampleAndGradientProgram(
    const Program& program,
    const SampleBatch& batch,
    std::span<float> values,
    const GradientSpans& gradients);
core::Interval
boundProgram(const Program& program, const core::Box& box, const core::Interval& radius);

} // namespace isofront::fields::graph
