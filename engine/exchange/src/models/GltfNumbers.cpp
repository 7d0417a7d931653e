// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.6.2.2 to 3.6.2.4.

#include "GltfNumbers.h"

#include <bit>
#include <string>

namespace isofront::exchange {

namespace {

/// Of vectors that are nowhere stored, and so are zero: more are a mistake.
constexpr std::size_t kMostZeros = std::size_t{1} << 20U;

tl::unexpected<core::Error> damaged(std::string what)
{
    return core::failure(core::ErrorCode::badData, std::move(what));
}

std::uint32_t littleEndian(const unsigned char* bytes, std::size_t count)
{
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < count; ++i)
        number |= static_cast<std::uint32_t>(bytes[i]) << 8 * i;
    return number;
}

double numberOf(const unsigned char* bytes, int type)
{
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return static_cast<std::int8_t>(*bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return *bytes;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return static_cast<std::int16_t>(littleEndian(bytes, 2));
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return littleEndian(bytes, 2);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return littleEndian(bytes, 4);
    default:
        return static_cast<double>(std::bit_cast<float>(littleEndian(bytes, 4)));
    }
}

std::size_t bytesOf(int type)
{
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return 4;
    default:
        return 0;
    }
}

/// Whether so many pieces, a stride apart, lie within so many bytes.
bool fit(
    std::size_t count, std::size_t stride, std::size_t size, std::size_t offset, std::size_t bytes)
{
    return offset <= bytes && size <= bytes - offset &&
           (count - 1) <= (bytes - offset - size) / stride;
}

} // namespace

core::Result<std::span<const unsigned char>>
bytesOfView(const tinygltf::Model& model, std::size_t view)
{
    if (view >= model.bufferViews.size())
        return damaged("it names buffer view " + std::to_string(view) + ", which is not there");
    const tinygltf::BufferView& found = model.bufferViews[view];
    const auto buffer = static_cast<std::size_t>(found.buffer);
    if (found.buffer < 0 || buffer >= model.buffers.size())
        return damaged("buffer view " + std::to_string(view) + " is of a buffer that is not there");
    const std::vector<unsigned char>& data = model.buffers[buffer].data;
    if (found.byteOffset > data.size() || found.byteLength > data.size() - found.byteOffset)
        return damaged("buffer view " + std::to_string(view) + " ends beyond its buffer");
    return std::span(data).subspan(found.byteOffset, found.byteLength);
}

core::Result<GltfNumbers>
GltfNumbers::open(const tinygltf::Model& model, int accessor, std::size_t least, std::size_t most)
{
    if (accessor < 0 || static_cast<std::size_t>(accessor) >= model.accessors.size())
        return damaged("it names accessor " + std::to_string(accessor) + ", which is not there");
    const std::string name = "accessor " + std::to_string(accessor);
    const tinygltf::Accessor& from = model.accessors[static_cast<std::size_t>(accessor)];
    GltfNumbers numbers;
    numbers._count = from.count;
    numbers._type = from.componentType;
    numbers._normalised = from.normalized && from.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT;
    const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(from.type));
    const std::size_t size = bytesOf(from.componentType) * static_cast<std::size_t>(components);
    if (components < 0 || static_cast<std::size_t>(components) < least ||
        static_cast<std::size_t>(components) > most || size == 0)
        return damaged(name + " is not of the kind that it is used as");
    numbers._components = static_cast<std::size_t>(components);
    if (from.bufferView >= 0 && from.count > 0) {
        const auto bytes = bytesOfView(model, static_cast<std::size_t>(from.bufferView));
        if (!bytes)
            return tl::unexpected(bytes.error());
        const std::size_t stride =
            model.bufferViews[static_cast<std::size_t>(from.bufferView)].byteStride;
        numbers._stride = stride == 0 ? size : stride;
        if (!fit(from.count, numbers._stride, size, from.byteOffset, bytes->size()))
            return damaged(
                name + " has " + std::to_string(from.count) +
                " elements, more than its buffer view holds");
        numbers._bytes = bytes->subspan(from.byteOffset);
    } else if (from.count > kMostZeros) {
        return damaged(
            name + " has " + std::to_string(from.count) + " elements, and no data for them");
    }
    if (from.sparse.isSparse || numbers._bytes.empty())
        if (const auto replaced = numbers.replaceSparse(model, from); !replaced)
            return tl::unexpected(replaced.error().within(name));
    return numbers;
}

core::Result<bool>
GltfNumbers::replaceSparse(const tinygltf::Model& model, const tinygltf::Accessor& from)
{
    std::vector<double> values(_count * _components);
    if (!_bytes.empty())
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = stored(_bytes.data() + i / _components * _stride, i % _components);
    if (from.sparse.isSparse && from.sparse.count > 0) {
        const auto count = static_cast<std::size_t>(from.sparse.count);
        const auto& [indexOffset, indexView, indexType] = from.sparse.indices;
        const auto& [valueView, valueOffset] = from.sparse.values;
        const auto indices = bytesOfView(model, static_cast<std::size_t>(indexView));
        const auto replaced = bytesOfView(model, static_cast<std::size_t>(valueView));
        if (!indices || !replaced)
            return tl::unexpected(!indices ? indices.error() : replaced.error());
        const std::size_t indexSize = bytesOf(indexType);
        const std::size_t size = bytesOf(_type) * _components;
        if (indexOffset < 0 || valueOffset < 0 || indexSize == 0 ||
            indexType == TINYGLTF_COMPONENT_TYPE_FLOAT ||
            !fit(
                count,
                indexSize,
                indexSize,
                static_cast<std::size_t>(indexOffset),
                indices->size()) ||
            !fit(count, size, size, static_cast<std::size_t>(valueOffset), replaced->size()))
            return damaged("its sparse values are more than their buffer views hold");
        for (std::size_t i = 0; i < count; ++i) {
            const auto index = static_cast<std::size_t>(littleEndian(
                indices->data() + static_cast<std::size_t>(indexOffset) + i * indexSize,
                indexSize));
            if (index >= _count)
                return damaged(
                    "its sparse value " + std::to_string(i) + " is for element " +
                    std::to_string(index) + " of " + std::to_string(_count));
            for (std::size_t c = 0; c < _components; ++c)
                values[index * _components + c] =
                    stored(replaced->data() + static_cast<std::size_t>(valueOffset) + i * size, c);
        }
    }
    _values = std::move(values);
    return true;
}

double GltfNumbers::stored(const unsigned char* vector, std::size_t component) const
{
    return numberOf(vector + component * bytesOf(_type), _type);
}

double GltfNumbers::share(std::size_t vector, std::size_t component) const
{
    const double value = number(vector, component);
    switch (_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return std::max(value / 127, -1.0);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return value / 255;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return std::max(value / 32767, -1.0);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return value / 65535;
    default:
        return value;
    }
}

} // namespace isofront::exchange
