#include "MeshReaders.h"

#include "ExchangeFixture.h"

#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <array>
#include <cstring>
#include <sstream>
#include <stdexcept>

namespace isofront::exchange::test {

namespace {

template <typename T>
T take(const std::string& bytes, std::size_t& at)
{
    T value{};
    if (at + sizeof(T) > bytes.size())
        throw std::runtime_error("the file ends at byte " + std::to_string(bytes.size()));
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    at += sizeof(T);
    return value;
}

double takeNumber(const std::string& type, const std::string& bytes, std::size_t& at)
{
    if (type == "double")
        return take<double>(bytes, at);
    if (type == "float")
        return static_cast<double>(take<float>(bytes, at));
    if (type == "uchar")
        return take<std::uint8_t>(bytes, at);
    if (type == "uint")
        return take<std::uint32_t>(bytes, at);
    if (type == "int")
        return take<std::int32_t>(bytes, at);
    throw std::runtime_error("unknown PLY type " + type);
}

/// The elements of an accessor as tinygltf lays them out, its own stride included.
template <typename T>
core::LargeVector<T> elements(const tinygltf::Model& model, int accessorIndex)
{
    const tinygltf::Accessor& accessor = model.accessors.at(std::size_t(accessorIndex));
    const tinygltf::BufferView& view = model.bufferViews.at(std::size_t(accessor.bufferView));
    const auto stride = std::size_t(accessor.ByteStride(view));
    core::LargeVector<T> result(accessor.count);
    for (std::size_t i = 0; i < accessor.count; ++i)
        std::memcpy(
            &result[i],
            &model.buffers.at(std::size_t(view.buffer))
                    .data.at(view.byteOffset + accessor.byteOffset + i * stride + sizeof(T) - 1) -
                (sizeof(T) - 1),
            sizeof(T));
    return result;
}

} // namespace

ReadMesh readGlb(const std::filesystem::path& path)
{
    tinygltf::TinyGLTF reader;
    tinygltf::Model model;
    std::string error;
    std::string warning;
    if (!reader.LoadBinaryFromFile(&model, &error, &warning, path.string()))
        throw std::runtime_error(error);
    EXPECT_EQ(error + warning, "");
    ReadMesh result;
    result.comments.push_back(model.asset.generator);
    if (model.meshes.empty())
        return result;
    EXPECT_EQ(model.meshes.size(), 1U);
    EXPECT_EQ(model.nodes.size(), 1U);
    EXPECT_EQ(model.scenes.at(0).nodes, std::vector<int>{0});
    const tinygltf::Node& node = model.nodes.at(0);
    EXPECT_EQ(node.mesh, 0);
    EXPECT_TRUE(node.rotation.empty() && node.scale.empty() && node.matrix.empty());
    glm::dvec3 translation(0);
    if (!node.translation.empty())
        translation = {node.translation.at(0), node.translation.at(1), node.translation.at(2)};

    const tinygltf::Primitive& primitive = model.meshes[0].primitives.at(0);
    EXPECT_EQ(model.meshes[0].primitives.size(), 1U);
    EXPECT_EQ(primitive.mode, TINYGLTF_MODE_TRIANGLES);
    const int positionAccessor = primitive.attributes.at("POSITION");
    glm::vec3 low(std::numeric_limits<float>::infinity());
    glm::vec3 high(-std::numeric_limits<float>::infinity());
    for (const glm::vec3& local : elements<glm::vec3>(model, positionAccessor)) {
        result.positions.push_back(translation + glm::dvec3(local));
        low = glm::min(low, local);
        high = glm::max(high, local);
    }
    const tinygltf::Accessor& accessor = model.accessors.at(std::size_t(positionAccessor));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(accessor.minValues.at(axis), double(low[axis])) << "axis " << axis;
        EXPECT_EQ(accessor.maxValues.at(axis), double(high[axis])) << "axis " << axis;
    }
    if (const auto normals = primitive.attributes.find("NORMAL");
        normals != primitive.attributes.end())
        result.normals = elements<glm::vec3>(model, normals->second);
    if (const auto words = primitive.attributes.find("_ATTRIBUTE");
        words != primitive.attributes.end()) {
        const auto& type = model.accessors.at(std::size_t(words->second));
        EXPECT_EQ(type.componentType, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE);
        EXPECT_EQ(type.type, TINYGLTF_TYPE_VEC4);
        for (const auto& bytes : elements<std::array<std::uint8_t, 4>>(model, words->second))
            result.attributes.push_back(
                bytes[0] | std::uint32_t{bytes[1]} << 8U | std::uint32_t{bytes[2]} << 16U |
                std::uint32_t{bytes[3]} << 24U);
    }
    if (model.accessors.at(std::size_t(primitive.indices)).componentType ==
        TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) {
        const auto indices = elements<std::uint16_t>(model, primitive.indices);
        result.indices.assign(indices.begin(), indices.end());
    } else
        result.indices = elements<std::uint32_t>(model, primitive.indices);
    return result;
}

ReadMesh readPly(const std::filesystem::path& path)
{
    struct Element {
        std::string name;
        std::size_t count = 0;
        std::vector<std::vector<std::string>> properties; // words after "property"
    };
    const std::string bytes = contentOf(path);
    std::size_t at = 0;
    const auto takeLine = [&] {
        const std::size_t end = bytes.find('\n', at);
        if (end == std::string::npos)
            throw std::runtime_error("the PLY header does not end");
        std::istringstream line(bytes.substr(at, end - at));
        at = end + 1;
        std::vector<std::string> words;
        for (std::string word; line >> word;)
            words.push_back(word);
        return words;
    };
    ReadMesh result;
    std::vector<Element> parts;
    EXPECT_EQ(takeLine(), std::vector<std::string>{"ply"});
    EXPECT_EQ(takeLine(), (std::vector<std::string>{"format", "binary_little_endian", "1.0"}));
    for (auto words = takeLine(); words.at(0) != "end_header"; words = takeLine()) {
        if (words[0] == "comment") {
            std::string comment;
            for (std::size_t i = 1; i < words.size(); ++i)
                comment += (i > 1 ? " " : "") + words[i];
            result.comments.push_back(comment);
        } else if (words[0] == "element")
            parts.push_back({words.at(1), std::stoul(words.at(2)), {}});
        else if (words[0] == "property")
            parts.back().properties.emplace_back(words.begin() + 1, words.end());
        else
            throw std::runtime_error("unknown PLY word " + words[0]);
    }
    for (const Element& part : parts)
        for (std::size_t i = 0; i < part.count; ++i) {
            glm::dvec3 position(0);
            glm::vec3 normal(0);
            bool hasNormal = false;
            for (const auto& property : part.properties) {
                if (property.at(0) == "list") {
                    const double count = takeNumber(property.at(1), bytes, at);
                    EXPECT_EQ(count, 3);
                    for (int corner = 0; corner < 3; ++corner)
                        result.indices.push_back(
                            static_cast<std::uint32_t>(takeNumber(property.at(2), bytes, at)));
                    continue;
                }
                const double number = takeNumber(property.at(0), bytes, at);
                const std::string& name = property.at(1);
                if (name == "attribute") {
                    result.attributes.push_back(static_cast<std::uint32_t>(number));
                    continue;
                }
                const std::size_t axis = std::string("xyz").find(name.back());
                if (name.size() == 1)
                    position[axis] = number;
                else
                    normal[axis] = static_cast<float>(number), hasNormal = true;
            }
            if (part.name == "vertex")
                result.positions.push_back(position);
            if (hasNormal)
                result.normals.push_back(normal);
        }
    EXPECT_EQ(at, bytes.size()) << "bytes after the last element";
    return result;
}

ReadMesh readObj(const std::filesystem::path& path)
{
    ReadMesh result;
    std::istringstream file(contentOf(path));
    for (std::string text; std::getline(file, text);) {
        std::istringstream line(text);
        std::string word;
        line >> word;
        if (word == "#")
            result.comments.push_back(text.substr(2));
        else if (word == "v") {
            glm::dvec3 v(0);
            line >> v.x >> v.y >> v.z;
            result.positions.push_back(v);
        } else if (word == "vn") {
            glm::vec3 v(0);
            line >> v.x >> v.y >> v.z;
            result.normals.push_back(v);
        } else if (word == "f") {
            int corners = 0;
            for (std::string corner; line >> corner; ++corners) {
                const std::size_t slash = corner.find('/');
                const std::string index = corner.substr(0, slash);
                if (slash != std::string::npos) {
                    EXPECT_EQ(corner, index + "//" + index);
                }
                result.indices.push_back(static_cast<std::uint32_t>(std::stoul(index) - 1));
            }
            EXPECT_EQ(corners, 3);
            continue;
        } else
            EXPECT_EQ(word, "o");
        EXPECT_TRUE(!line.fail() || word == "#" || word == "o") << text;
    }
    return result;
}

ReadMesh readStl(const std::filesystem::path& path)
{
    const std::string bytes = contentOf(path);
    ReadMesh result;
    result.comments.push_back(bytes.substr(0, 80));
    std::size_t at = 80;
    const auto count = take<std::uint32_t>(bytes, at);
    for (std::uint32_t triangle = 0; triangle < count; ++triangle) {
        result.normals.push_back(take<glm::vec3>(bytes, at));
        for (int corner = 0; corner < 3; ++corner) {
            result.indices.push_back(static_cast<std::uint32_t>(result.positions.size()));
            result.positions.emplace_back(take<glm::vec3>(bytes, at));
        }
        EXPECT_EQ(take<std::uint16_t>(bytes, at), 0);
    }
    EXPECT_EQ(at, bytes.size());
    return result;
}

} // namespace isofront::exchange::test
