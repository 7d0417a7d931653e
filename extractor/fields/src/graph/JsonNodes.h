#pragma once

#include "graph/JsonObject.h"
#include "isofront/fields/GraphJson.h"

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace isofront::fields::graph {

// Lengths from a micrometre to beyond the Earth's orbit, and what they can be factors of.
inline constexpr double kShortest = 1e-6;
inline constexpr double kLongest = 1e12;

/// Makes the nodes of a document, each once. All members throw Problem, which names the node by its
/// path, as in 'land.inputs.1'.
class JsonNodes {
public:
    /// @param nodes, files  must outlive it
    JsonNodes(const Json& nodes, const PresetFiles& files);

    /// What a key outside of `nodes` gives as its value: the name of a node, a node, or a number.
    /// @param where  the path of the object
    Node input(JsonObject& object, const std::string& key, const std::string& where);

    /// A name nobody uses is most likely a slip of the pen.
    void checkAllUsed() const;

private:
    using Make = Node (JsonNodes::*)(JsonObject&);
    static const std::map<std::string, Make>& types();

    Node named(JsonObject& object, const std::string& key, const std::string& name);
    Node made(const Json& value, const std::string& where);
    Node resolved(JsonObject& object, const Json& value, const std::string& key);
    Node input(JsonObject& object, const std::string& key);
    Node input(JsonObject& object, const std::string& key, double otherwise);
    template <typename Join>
    Node joined(JsonObject& object, const Join& join);

    std::uint64_t seedOf(JsonObject& object, const std::string& suffix = "");
    OctaveSettings octaves(JsonObject& object, const std::string& suffix = "");
    Node loaded(JsonObject& object, FileRequest request);
    void count(const JsonObject& object);
    [[nodiscard]] std::vector<std::string> names() const;

    // One for each type.
    Node position(JsonObject& object);
    Node distance(JsonObject& object);
    Node noise(JsonObject& object);
    Node filterWeight(JsonObject& object);
    Node elevation(JsonObject& object);
    Node volume(JsonObject& object);
    Node add(JsonObject& object);
    Node subtract(JsonObject& object);
    Node multiply(JsonObject& object);
    Node abs(JsonObject& object);
    Node square(JsonObject& object);
    Node sqrt(JsonObject& object);
    Node min(JsonObject& object);
    Node max(JsonObject& object);
    Node smoothMin(JsonObject& object);
    Node smoothMax(JsonObject& object);
    Node clamp(JsonObject& object);
    Node smoothStep(JsonObject& object);
    Node mix(JsonObject& object);
    Node curve(JsonObject& object);
    Node warp(JsonObject& object);
    Node placed(JsonObject& object);
    Node detail(JsonObject& object);
    Node tunnels(JsonObject& object);

    const Json& _nodes;
    const PresetFiles& _files;
    std::map<std::string, Node> _made;
    std::vector<std::string> _open;  ///< names of the nodes that are being made, outermost first
    std::vector<std::string> _paths; ///< of the objects that are being read
    std::map<std::string, std::shared_ptr<const Field>> _loaded; ///< by what was asked for
    std::size_t _count = 0;
    int _depth = 0;
};

} // namespace isofront::fields::graph
