// Based on: Khronos Group, "glTF 2.0 Specification", 2021.

#include "GltfNumbers.h"
#include "ModelBudget.h"
#include "ModelFormats.h"
#include "Picture.h"

#include <isofront/core/Affine.h>
#include <isofront/raster/FileBytes.h>

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace isofront::exchange {

namespace {

using Problem = std::optional<core::Error>;

/// The library parses nested values by recursion; deeper ones are no scene.
constexpr int kMostNesting = 200;

core::Error damaged(std::string what)
{
    return {core::ErrorCode::badData, std::move(what)};
}

/// Extensions that may be required: those that change how a mesh looks, not what it is.
bool isHarmless(const std::string& extension)
{
    return extension == "KHR_mesh_quantization" || extension == "KHR_texture_transform" ||
           extension == "KHR_lights_punctual" || extension.starts_with("KHR_materials_");
}

bool nestsTooDeep(std::string_view json)
{
    int depth = 0;
    bool isText = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (isText) {
            if (c == '\\')
                ++i;
            isText = c != '"';
        } else if (c == '"') {
            isText = true;
        } else if (c == '{' || c == '[') {
            if (++depth > kMostNesting)
                return true;
        } else if (c == '}' || c == ']') {
            --depth;
        }
    }
    return false;
}

/// The files that a scene names, for the library.
struct FilesBeside {
    std::uint64_t mostBytes = 0;
    OtherFiles use = OtherFiles::read;
    Problem problem; ///< of the last one that could not be read

    static bool exists(const std::string& path, void* self)
    {
        auto& files = *static_cast<FilesBeside*>(self);
        if (files.use == OtherFiles::ignore) {
            files.problem = damaged("a part of it lies in another file, which isn't read");
            return false;
        }
        const auto readable = raster::checkReadable(path);
        if (!readable)
            files.problem = readable.error().within(path);
        return readable.has_value();
    }
    static std::string sameName(const std::string& path, void*) { return path; }
    static bool
    read(std::vector<unsigned char>* out, std::string* error, const std::string& path, void* self)
    {
        auto& files = *static_cast<FilesBeside*>(self);
        if (files.use == OtherFiles::ignore)
            return false; // not asked for: it doesn't exist
        const auto bytes =
            raster::readFileBytes(path, files.mostBytes, core::ErrorCode::resourceLimit);
        if (!bytes) {
            files.problem = bytes.error().within(path);
            *error += bytes.error().message;
            return false;
        }
        files.problem.reset();
        out->resize(bytes->size());
        std::memcpy(out->data(), bytes->data(), bytes->size());
        return true;
    }
    static bool write(std::string*, const std::string&, const std::vector<unsigned char>&, void*)
    {
        return false; // nothing is written
    }
};

/// Keeps a picture as it is stored: most are not needed. What lies in a buffer stays there.
bool keepPicture(
    tinygltf::Image* image,
    int,
    std::string*,
    std::string*,
    int,
    int,
    const unsigned char* bytes,
    int size,
    void*)
{
    if (image->bufferView < 0 && size > 0)
        image->image.assign(bytes, bytes + size);
    return true;
}

core::Result<tinygltf::Model> parsed(std::span<const std::byte> bytes, const ModelContext& context)
{
    const auto fail = [](std::string what) -> core::Result<tinygltf::Model> {
        return tl::unexpected(damaged(std::move(what)));
    };
    constexpr std::size_t kJsonAt = 20;
    const auto* const begin = reinterpret_cast<const char*>(bytes.data());
    const bool isBinary = bytes.size() >= 4 && std::memcmp(begin, "glTF", 4) == 0;
    if (bytes.size() > 0xffffffffU)
        return fail("it is larger than 4 GiB, which glTF can't be");
    std::string_view json(begin, bytes.size());
    if (isBinary) {
        if (bytes.size() < kJsonAt)
            return fail("it ends within its header");
        std::uint32_t length = 0;
        std::memcpy(&length, begin + 12, sizeof length); // of this machine, little-endian
        json = json.substr(kJsonAt, length);
    }
    if (nestsTooDeep(json))
        return fail("its JSON nests too deep");

    FilesBeside files{context.mostBytes, context.otherFiles, std::nullopt};
    tinygltf::TinyGLTF reader;
    reader.SetImageLoader(keepPicture, nullptr);
    reader.SetFsCallbacks(
        {FilesBeside::exists,
         FilesBeside::sameName,
         FilesBeside::read,
         FilesBeside::write,
         &files});
    tinygltf::Model model;
    std::string error;
    std::string warning;
    const std::string folder = context.folder.empty() ? "." : context.folder.string();
    const auto size = static_cast<unsigned int>(bytes.size());
    bool good = false;
    try {
        good = isBinary ? reader.LoadBinaryFromMemory(
                              &model,
                              &error,
                              &warning,
                              reinterpret_cast<const unsigned char*>(begin),
                              size,
                              folder)
                        : reader.LoadASCIIFromString(&model, &error, &warning, begin, size, folder);
    } catch (const std::exception& thrown) {
        error = thrown.what();
    }
    if (good)
        return model;
    if (files.problem)
        return tl::unexpected(*files.problem);
    std::ranges::replace(error, '\n', ' ');
    return fail("it is no valid glTF: " + error);
}

glm::dmat3 rotationOf(const std::vector<double>& q)
{
    const double squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (!(squared > 0))
        return glm::dmat3(1);
    const double s = 2 / squared;
    const double x = q[0];
    const double y = q[1];
    const double z = q[2];
    const double w = q[3];
    return {
        {1 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)},
        {s * (x * y - z * w), 1 - s * (x * x + z * z), s * (y * z + x * w)},
        {s * (x * z + y * w), s * (y * z - x * w), 1 - s * (x * x + y * y)}};
}

core::Affine affineOf(const std::vector<double>& m)
{
    return {{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}}, {m[12], m[13], m[14]}};
}

core::Affine mapOf(const tinygltf::Node& node)
{
    if (node.matrix.size() == 16)
        return affineOf(node.matrix);
    core::Affine map;
    if (node.rotation.size() == 4)
        map.linear = rotationOf(node.rotation);
    if (node.scale.size() == 3)
        for (std::size_t column = 0; column < 3; ++column)
            map.linear[column] *= node.scale[column];
    if (node.translation.size() == 3)
        map.translation = {node.translation[0], node.translation[1], node.translation[2]};
    return map;
}

/// First the inner map, then the outer one.
core::Affine composed(const core::Affine& outer, const core::Affine& inner)
{
    return {outer.linear * inner.linear, outer.point(inner.translation)};
}

std::uint32_t srgbOf(double linear)
{
    const double c = linear > 0 ? std::min(linear, 1.0) : 0; // nothing where it is no number
    const double s = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
    return static_cast<std::uint32_t>(std::lround(255 * s));
}

/// Puts the meshes of a scene together.
class Assembly {
public:
    Assembly(const tinygltf::Model& gltf, std::uint64_t mostBytes)
        : _gltf(gltf), _mostBytes(mostBytes), _budget(mostBytes)
    {
    }

    Problem run()
    {
        for (const std::string& extension : _gltf.extensionsRequired)
            if (!isHarmless(extension))
                return damaged(
                    "it can't be read without " + extension + "; save it without that extension");
        if (auto failed = placeNodes())
            return failed;
        for (std::size_t node = 0; node < _gltf.nodes.size(); ++node)
            if (_maps[node] && _gltf.nodes[node].mesh >= 0)
                if (auto failed = addNode(node))
                    return failed->within("node " + std::to_string(node));
        if (!_isColoured)
            _model.colours.clear();
        if (_model.textures.empty()) {
            _model.textureOf.clear();
            _model.textureCorners.clear();
        }
        _model.notes.assign(_notes.begin(), _notes.end());
        return std::nullopt;
    }
    voxels::TriangleModel take() { return std::move(_model); }

private:
    /// Where each node of the scene comes to lie.
    Problem placeNodes()
    {
        _maps.resize(_gltf.nodes.size());
        std::vector<std::pair<int, core::Affine>> open;
        const auto scene = static_cast<std::size_t>(std::max(_gltf.defaultScene, 0));
        if (scene < _gltf.scenes.size()) {
            for (const int node : _gltf.scenes[scene].nodes)
                open.emplace_back(node, core::Affine{});
        } else {
            std::vector<bool> isChild(_gltf.nodes.size());
            for (const tinygltf::Node& node : _gltf.nodes)
                for (const int child : node.children)
                    if (child >= 0 && static_cast<std::size_t>(child) < isChild.size())
                        isChild[static_cast<std::size_t>(child)] = true;
            for (std::size_t node = 0; node < isChild.size(); ++node)
                if (!isChild[node])
                    open.emplace_back(static_cast<int>(node), core::Affine{});
        }
        while (!open.empty()) {
            const auto [number, parent] = open.back();
            open.pop_back();
            const auto node = static_cast<std::size_t>(number);
            if (number < 0 || node >= _gltf.nodes.size())
                return damaged("it names node " + std::to_string(number) + ", which is not there");
            if (_maps[node])
                return damaged("node " + std::to_string(number) + " is in the scene twice");
            _maps[node] = composed(parent, mapOf(_gltf.nodes[node]));
            for (const int child : _gltf.nodes[node].children)
                open.emplace_back(child, *_maps[node]);
        }
        return std::nullopt;
    }

    Problem addNode(std::size_t node)
    {
        const auto mesh = static_cast<std::size_t>(_gltf.nodes[node].mesh);
        if (mesh >= _gltf.meshes.size())
            return damaged("it names mesh " + std::to_string(mesh) + ", which is not there");
        const int skin = _gltf.nodes[node].skin;
        std::vector<core::Affine> joints;
        if (skin >= 0)
            if (auto failed = findJoints(static_cast<std::size_t>(skin), joints))
                return failed;
        for (const tinygltf::Primitive& primitive : _gltf.meshes[mesh].primitives)
            if (auto failed = addPrimitive(primitive, *_maps[node], joints))
                return failed->within("mesh " + std::to_string(mesh));
        if (!_gltf.animations.empty() && skin >= 0)
            _notes.insert("animated parts are taken as they stand before the animation");
        return std::nullopt;
    }

    /// From where vertices are stored to where each joint of a skin takes them.
    Problem findJoints(std::size_t skin, std::vector<core::Affine>& joints) const
    {
        if (skin >= _gltf.skins.size())
            return damaged("it names skin " + std::to_string(skin) + ", which is not there");
        const tinygltf::Skin& found = _gltf.skins[skin];
        std::optional<GltfNumbers> inverse;
        if (found.inverseBindMatrices >= 0) {
            auto numbers = GltfNumbers::open(_gltf, found.inverseBindMatrices, 16, 16);
            if (!numbers)
                return numbers.error();
            if (numbers->size() < found.joints.size())
                return damaged("skin " + std::to_string(skin) + " has too few matrices");
            inverse = std::move(*numbers);
        }
        for (std::size_t i = 0; i < found.joints.size(); ++i) {
            const auto joint = static_cast<std::size_t>(found.joints[i]);
            if (found.joints[i] < 0 || joint >= _maps.size() || !_maps[joint])
                return damaged("skin " + std::to_string(skin) + " has a joint outside the scene");
            core::Affine bind;
            if (inverse) {
                std::vector<double> m(16);
                for (std::size_t k = 0; k < m.size(); ++k)
                    m[k] = inverse->at(i, k);
                bind = affineOf(m);
            }
            joints.push_back(composed(*_maps[joint], bind));
        }
        return std::nullopt;
    }

    core::Result<std::optional<GltfNumbers>> attribute(
        const tinygltf::Primitive& primitive,
        const std::string& name,
        std::size_t least,
        std::size_t most,
        std::size_t vertices) const
    {
        const auto found = primitive.attributes.find(name);
        if (found == primitive.attributes.end())
            return std::optional<GltfNumbers>();
        auto numbers = GltfNumbers::open(_gltf, found->second, least, most);
        if (!numbers)
            return tl::unexpected(numbers.error().within(name));
        if (numbers->size() != vertices)
            return tl::unexpected(damaged(
                name + " has " + std::to_string(numbers->size()) + " elements for " +
                std::to_string(vertices) + " positions"));
        return std::optional<GltfNumbers>(std::move(*numbers));
    }

    Problem addPrimitive(
        const tinygltf::Primitive& primitive,
        const core::Affine& map,
        const std::vector<core::Affine>& joints)
    {
        const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
        if (mode < TINYGLTF_MODE_TRIANGLES || mode > TINYGLTF_MODE_TRIANGLE_FAN) {
            _notes.insert("points and lines are left out");
            return std::nullopt;
        }
        if (primitive.extensions.contains("KHR_draco_mesh_compression"))
            return damaged("it is compressed by Draco; save it without that extension");
        const auto named = primitive.attributes.find("POSITION");
        if (named == primitive.attributes.end()) {
            _notes.insert("parts without positions are left out");
            return std::nullopt;
        }
        if (!primitive.targets.empty())
            _notes.insert("shapes to morph into are left out");
        const auto positions = GltfNumbers::open(_gltf, named->second, 3, 3);
        if (!positions)
            return positions.error().within("POSITION");
        std::optional<GltfNumbers> indices;
        if (primitive.indices >= 0) {
            auto numbers = GltfNumbers::open(_gltf, primitive.indices, 1, 1);
            if (!numbers)
                return numbers.error();
            if (!numbers->areUnsigned())
                return damaged("its indices are not integers without a sign");
            indices = std::move(*numbers);
        }
        const std::size_t corners = indices ? indices->size() : positions->size();
        const std::uint64_t triangles = mode == TINYGLTF_MODE_TRIANGLES ? corners / 3
                                        : corners < 3                   ? 0
                                                                        : corners - 2;
        const std::uint64_t first = _model.positions.size();
        if (auto failed = _budget.check(_model, {positions->size(), triangles}))
            return failed;
        if (auto failed = addPositions(primitive, *positions, map, joints))
            return failed;

        Paint paint;
        if (auto failed = addColours(primitive, positions->size(), paint))
            return failed;
        const bool turned = joints.empty() && map.mirrors();
        const auto cornerAt = [&](std::uint64_t i) {
            return indices ? static_cast<std::uint32_t>(indices->number(i, 0))
                           : static_cast<std::uint32_t>(i);
        };
        for (std::uint64_t i = 0; i < triangles; ++i) {
            std::array<std::uint64_t, 3> at{3 * i, 3 * i + 1, 3 * i + 2};
            if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) // every other one runs the other way
                at = {i, i + 1 + i % 2, i + 2 - i % 2};
            else if (mode == TINYGLTF_MODE_TRIANGLE_FAN)
                at = {i + 1, i + 2, 0};
            std::array<std::uint32_t, 3> triangle{
                cornerAt(at[0]), cornerAt(at[1]), cornerAt(at[2])};
            if (turned)
                std::swap(triangle[1], triangle[2]);
            addTriangle(triangle, static_cast<std::uint32_t>(first), positions->size(), paint);
        }
        return std::nullopt;
    }

    Problem addPositions(
        const tinygltf::Primitive& primitive,
        const GltfNumbers& positions,
        const core::Affine& map,
        const std::vector<core::Affine>& joints)
    {
        const auto stored = [&](std::size_t i) {
            return glm::dvec3(positions.at(i, 0), positions.at(i, 1), positions.at(i, 2));
        };
        const std::size_t first = _model.positions.size();
        if (joints.empty()) {
            for (std::size_t i = 0; i < positions.size(); ++i)
                _model.positions.push_back(map.point(stored(i)));
            return std::nullopt;
        }
        // the mean of where its joints take a vertex; where the node itself stands says nothing
        _model.positions.resize(first + positions.size());
        for (int set = 0;; ++set) {
            const std::string number = std::to_string(set);
            const auto which = attribute(primitive, "JOINTS_" + number, 4, 4, positions.size());
            const auto weights = attribute(primitive, "WEIGHTS_" + number, 4, 4, positions.size());
            if (!which || !weights)
                return !which ? which.error() : weights.error();
            if (!*which || !*weights)
                break;
            if (!(*which)->areUnsigned())
                return damaged("JOINTS_" + number + " are not integers without a sign");
            for (std::size_t i = 0; i < positions.size(); ++i)
                for (std::size_t k = 0; k < 4; ++k) {
                    const double weight = (*weights)->share(i, k);
                    const auto joint = static_cast<std::size_t>((*which)->number(i, k));
                    if (weight == 0)
                        continue;
                    if (joint >= joints.size())
                        return damaged(
                            "vertex " + std::to_string(i) + " names joint " +
                            std::to_string(joint) + " of " + std::to_string(joints.size()));
                    _model.positions[first + i] += weight * joints[joint].point(stored(i));
                }
        }
        return std::nullopt;
    }

    /// How the triangles of a part are coloured, beside the colours of positions.
    struct Paint {
        std::uint32_t texture = voxels::kNoTexture;
        std::optional<GltfNumbers> places;
    };

    Problem addColours(const tinygltf::Primitive& primitive, std::size_t vertices, Paint& paint)
    {
        std::array<double, 4> factor{1, 1, 1, 1};
        bool isOpaque = true;
        if (primitive.material >= 0) {
            const auto number = static_cast<std::size_t>(primitive.material);
            if (number >= _gltf.materials.size())
                return damaged(
                    "it names material " + std::to_string(number) + ", which is not there");
            const tinygltf::Material& material = _gltf.materials[number];
            const auto& base = material.pbrMetallicRoughness;
            isOpaque = material.alphaMode != "MASK" && material.alphaMode != "BLEND";
            for (std::size_t i = 0; i < factor.size() && i < base.baseColorFactor.size(); ++i)
                factor[i] = base.baseColorFactor[i];
            if (base.baseColorTexture.index >= 0)
                if (auto failed =
                        findTexture(primitive, base.baseColorTexture, isOpaque, vertices, paint))
                    return failed;
        }
        const auto colours = attribute(primitive, "COLOR_0", 3, 4, vertices);
        if (!colours)
            return colours.error();
        _isColoured = _isColoured || *colours || factor != std::array<double, 4>{1, 1, 1, 1};
        for (std::size_t vertex = 0; vertex < vertices; ++vertex) {
            std::array<double, 4> colour = factor;
            if (*colours)
                for (std::size_t i = 0; i < (*colours)->components(); ++i)
                    colour[i] *= (*colours)->share(vertex, i);
            const double opacity = isOpaque ? 1 : std::clamp(colour[3], 0.0, 1.0);
            _model.colours.push_back(
                srgbOf(colour[0]) | srgbOf(colour[1]) << 8U | srgbOf(colour[2]) << 16U |
                static_cast<std::uint32_t>(std::lround(255 * (opacity >= 0 ? opacity : 0))) << 24U);
        }
        return std::nullopt;
    }

    Problem findTexture(
        const tinygltf::Primitive& primitive,
        const tinygltf::TextureInfo& info,
        bool isOpaque,
        std::size_t vertices,
        Paint& paint)
    {
        const std::string set = "TEXCOORD_" + std::to_string(info.texCoord);
        auto places = attribute(primitive, set, 2, 2, vertices);
        if (!places)
            return places.error();
        if (!*places) {
            _notes.insert("textures without places (" + set + ") are left out");
            return std::nullopt;
        }
        if (info.extensions.contains("KHR_texture_transform"))
            _notes.insert("transforms of textures are left out");
        const auto known = _textures.find({info.index, isOpaque});
        if (known != _textures.end()) {
            paint.texture = known->second;
        } else {
            auto texture = loadTexture(static_cast<std::size_t>(info.index), isOpaque);
            if (texture) {
                paint.texture = static_cast<std::uint32_t>(_model.textures.size());
                _model.textures.push_back(std::move(*texture));
            } else {
                _notes.insert(
                    "texture " + std::to_string(info.index) +
                    " is left out: " + texture.error().message);
            }
            _textures[{info.index, isOpaque}] = paint.texture;
        }
        paint.places = std::move(*places);
        return std::nullopt;
    }

    core::Result<voxels::Texture> loadTexture(std::size_t number, bool isOpaque) const
    {
        if (number >= _gltf.textures.size())
            return tl::unexpected(damaged("it is not there"));
        const tinygltf::Texture& from = _gltf.textures[number];
        if (from.source < 0 || static_cast<std::size_t>(from.source) >= _gltf.images.size())
            return tl::unexpected(damaged("it has no PNG or JPEG picture"));
        const tinygltf::Image& stored = _gltf.images[static_cast<std::size_t>(from.source)];
        std::span<const unsigned char> bytes(stored.image);
        if (stored.bufferView >= 0) {
            const auto view = bytesOfView(_gltf, static_cast<std::size_t>(stored.bufferView));
            if (!view)
                return tl::unexpected(view.error());
            bytes = *view;
        }
        auto image = decodePicture(std::as_bytes(bytes), _mostBytes);
        if (!image)
            return tl::unexpected(image.error());
        voxels::Texture texture{std::move(*image)};
        if (isOpaque)
            for (std::size_t i = 3; i < texture.image.rgba.size(); i += 4)
                texture.image.rgba[i] = 255;
        const auto wrapOf = [](int wrap) {
            return wrap == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? voxels::Texture::Wrap::clamp
                   : wrap == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? voxels::Texture::Wrap::mirror
                                                                   : voxels::Texture::Wrap::repeat;
        };
        if (from.sampler >= 0 && static_cast<std::size_t>(from.sampler) < _gltf.samplers.size()) {
            const tinygltf::Sampler& sampler =
                _gltf.samplers[static_cast<std::size_t>(from.sampler)];
            texture.acrossX = wrapOf(sampler.wrapS);
            texture.acrossY = wrapOf(sampler.wrapT);
        }
        return texture;
    }

    /// @param triangle  of the part's own vertices
    void addTriangle(
        const std::array<std::uint32_t, 3>& triangle,
        std::uint32_t first,
        std::size_t vertices,
        const Paint& paint)
    {
        const bool isThere = std::ranges::all_of(triangle, [&](auto i) { return i < vertices; });
        std::array<std::uint32_t, 3> corners{};
        std::array<glm::vec2, 3> places{glm::vec2(0), glm::vec2(0), glm::vec2(0)};
        for (std::size_t corner = 0; corner < 3; ++corner) {
            // an index past the part's vertices must not name one of another part
            corners[corner] = isThere ? first + triangle[corner] : 0xffffffffU;
            if (isThere && paint.places)
                places[corner] = glm::vec2(
                    paint.places->at(triangle[corner], 0), paint.places->at(triangle[corner], 1));
        }
        _model.triangles.push_back(corners);
        _model.textureOf.push_back(paint.texture);
        _model.textureCorners.push_back(places);
    }

    const tinygltf::Model& _gltf;
    std::uint64_t _mostBytes;
    ModelBudget _budget;
    voxels::TriangleModel _model;
    std::vector<std::optional<core::Affine>> _maps; ///< of nodes that are in the scene
    std::map<std::pair<int, bool>, std::uint32_t> _textures;
    std::set<std::string> _notes;
    bool _isColoured = false;
};

} // namespace

core::Result<voxels::TriangleModel>
readGltf(std::span<const std::byte> bytes, const ModelContext& context)
{
    const auto gltf = parsed(bytes, context);
    if (!gltf)
        return tl::unexpected(gltf.error());
    Assembly assembly(*gltf, context.mostBytes);
    if (auto failed = assembly.run())
        return tl::unexpected(*failed);
    return assembly.take();
}

} // namespace isofront::exchange
