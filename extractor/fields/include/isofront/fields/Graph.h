#pragma once

#include <isofront/fields/Field.h>
#include <isofront/fields/Noise.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// Fields put together from nodes: noise, arithmetic, joins and warps.
///
///     using namespace isofront::fields::graph;
///     const Node hills = noise({.wavelength = 900, .octaves = 6, .amplitude = 120, .plane =
///     true}); const Node ground = hills - position(Axis::z); auto field =
///     graphField(smoothMax(ground, 40.0 - distance(0, 0, 200), 10), {.seed = 7});
///
/// A node stands for a function of place and filter radius. What it does to the filter is said with
/// each: noise is band-limited octave by octave, by the weights of `OctaveSettings`; all other
/// nodes work upon what their inputs make of the filter, and have none of their own. A sharp edge
/// that a node makes, of `min` or of `abs`, is therefore as sharp at any radius.
///
/// Every node can be bounded over a box, and has an analytic gradient. Nodes are handles to
/// immutable parts: copying is cheap, and what is used twice is computed once.
namespace isofront::fields::graph {

struct NodeData;

enum class Axis { x, y, z };

/// A node of a graph, or a constant.
class Node {
public:
    /// The same value everywhere. Finite, and not beyond 1e30 (asserted).
    Node(double value); // NOLINT(google-explicit-constructor): numbers mix with nodes in formulas

    explicit Node(std::shared_ptr<const NodeData> data) : _data(std::move(data)) {}
    [[nodiscard]] const std::shared_ptr<const NodeData>& data() const { return _data; }

private:
    std::shared_ptr<const NodeData> _data;
};

/// A coordinate of the place [field]. In double until it is used, then in float.
Node position(Axis axis);

/// Octaves of noise, from long waves to short ones.
struct OctaveSettings {
    NoiseKind kind = NoiseKind::gradient;
    FractalKind fractal = FractalKind::brownian;
    double wavelength = 1;    ///< of the first octave [field], > 0
    int octaves = 1;          ///< 0 to 32
    double amplitude = 1;     ///< factor on the noise of the first octave
    double lacunarity = 2.03; ///< frequency of an octave over that of the one before, >= 1
    double gain = 0.5;        ///< amplitude of an octave over that of the one before
    double stretch = 1;     ///< in space: how much shorter waves are along z; above 1 makes strata
    double carry = 4;       ///< of ridges: how soon they carry further ridges; higher is rougher
    bool plane = false;     ///< noise over the plane of x and y, the same at every z
    bool filtered = true;   ///< false: the same at any radius, for noise that places other things
    std::uint64_t seed = 0; ///< nodes of the same settings but another seed have different noise
};

/// Octaves of noise put together: a plain sum, ridges or billows.
///
/// An octave of frequency f carries the weight exp(-(kappa f r)^2) at filter radius r (Scholz et
/// al., eq. 2 and 3); where it is zero, from kappa f r = 3 on, the octave costs nothing. Octaves of
/// ridges and billows are taken about their mean, so that the filter takes their shape away and
/// leaves the height.
///
/// Source of ridges: Musgrave, Kolb, Mace, "The synthesis and rendering of eroded fractal terrains"
/// (1989), and Musgrave's ridged multifractal in "Texturing and Modeling": only ridges carry
/// further ridges, so that valleys stay smooth.
Node noise(const OctaveSettings& settings);

/// The weight of a wave of the given length [field] at the place's filter radius: 1 unfiltered, 0
/// where the wave is filtered away. A factor on whatever has that size.
Node filterWeight(double wavelength);

/// Another field. It filters itself; bounds and gradients are its own.
Node source(std::shared_ptr<const Field> field);

Node operator+(const Node& a, const Node& b);
Node operator-(const Node& a, const Node& b);
Node operator*(const Node& a, const Node& b);
Node operator-(const Node& a);

Node abs(const Node& a);
Node square(const Node& a);
/// The square root; 0 of what is below zero.
Node sqrt(const Node& a);

Node min(const Node& a, const Node& b);
Node max(const Node& a, const Node& b);
/// The lesser of two, rounded off where they differ by less than `width` (> 0); there it lies up to
/// `width / 4` below both.
Node smoothMin(const Node& a, const Node& b, double width);
Node smoothMax(const Node& a, const Node& b, double width);
Node clamp(const Node& a, double low, double high);
/// 0 below `begin`, 1 above `end`, a cubic between; `end` above `begin`.
Node smoothStep(const Node& a, double begin, double end);
/// `a` where t is 0, `b` where it is 1.
Node mix(const Node& a, const Node& b, const Node& t);

struct CurvePoint {
    double at;
    double value;
};
/// A smooth curve through the points, that doesn't overshoot: monotone between two neighbours, and
/// constant before the first and after the last.
/// Source: Fritsch, Carlson, "Monotone piecewise cubic interpolation" (1980), with the slopes of
/// Fritsch and Butland.
/// @param points  1 to 64, `at` rising
Node curve(const Node& a, std::span<const CurvePoint> points);

/// The distance from a point [field].
Node distance(double x, double y, double z);

/// The node at a place that is moved by (dx, dy, dz). The filter radius inside is `stretch` times
/// that outside: 1 keeps all detail; the most by which the warp squeezes lengths avoids aliasing.
Node warp(const Node& node, const Node& dx, const Node& dy, const Node& dz, double stretch = 1);

/// The node made `scale` (> 0) times as large about the origin and then moved; its values stay.
/// The filter radius is divided by `scale`.
Node placed(const Node& node, double x, double y, double z, double scale = 1);

/// Adds octaves of detail to something like a distance. An octave is faded out where the value is
/// so far from zero that this and all later octaves can't change its sign: there it costs nothing.
/// @param layers    sets of octaves in space, plain sums; they are applied from the strongest
/// octave to the weakest
/// @param strength  a factor on all of them, from 0 to 1
/// @param reserve   how far nodes that come later may still move the value
Node detail(
    const Node& base,
    std::span<const OctaveSettings> layers,
    const Node& strength = 1.0,
    double reserve = 0);

/// Winding tunnels, cut out of a solid down to some depth.
struct TunnelSettings {
    double wavelength = 700;      ///< how far a tunnel runs before it turns [field]
    double radius = 20;           ///< [field]
    double radiusVariation = 0.6; ///< of the radius, relative: tunnels widen to halls and end
    double depth = 300;           ///< deepest below the surface [field]
    double stretch = 1;           ///< above 1: flatter tunnels
    double rounding = 8;          ///< of the rims [field]
    std::uint64_t seed = 0;
};
/// Tunnels run where two sheets of noise, each zero on winding surfaces, are both zero. They close
/// as the filter removes waves of four times their radius.
/// @param solid  something like a distance, positive inside
Node tunnels(const Node& solid, const TunnelSettings& settings);

/// How many nodes a graph may have, after what is used twice has been joined.
inline constexpr std::size_t kMostNodes = 4096;
/// True if the graph has no more than that; what is used within two warps counts twice.
bool fits(const Node& node);

struct GraphSettings {
    std::uint64_t seed = 1;    ///< changes all noise
    double filterStrength = 1; ///< kappa, see NoiseSettings
};

/// What a part of the surface is made of.
struct Material {
    std::string name;
    std::uint32_t colour = 0;  ///< 0xBBGGRR
    std::optional<Node> where; ///< it is there where this is at or above 0; nothing: everywhere
};

/// How many materials a field may tell apart.
inline constexpr std::size_t kMostMaterials = 255;

/// The graph as a field. The graph is turned into a program once, and runs on blocks of points on
/// the best instruction set of the machine; the same bits come from all of them.
///
/// Parts that can't matter are left out: the second operand of a minimum where the first is below
/// all that it can be, a factor of zero's other factor, and so on. What is left out changes no bit.
///
/// Attributes are the first material that is there: 0xNNBBGGRR, with NN its number in the list,
/// counted from 1, and the colour; 0 where there is none. Where a material is depends on the filter
/// radius like all else that the graph says.
///
/// Needs graphs of at most `kMostNodes` nodes each, and at most `kMostMaterials` (asserted).
std::shared_ptr<const Field> graphField(
    const Node& node, const GraphSettings& settings = {}, std::span<const Material> materials = {});

} // namespace isofront::fields::graph
