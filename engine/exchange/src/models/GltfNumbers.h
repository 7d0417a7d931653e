#pragma once

#include <isofront/core/Result.h>

#include <tiny_gltf.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace isofront::exchange {

/// The bytes of a buffer view, as far as they are there.
core::Result<std::span<const unsigned char>>
bytesOfView(const tinygltf::Model& model, std::size_t view);

/// What a glTF accessor gives access to: vectors of numbers, however they are stored. The model
/// must outlive it.
class GltfNumbers {
public:
    /// Fails with `badData` if any of it isn't there, or not of the kind named.
    /// @param least, most  components of a vector
    static core::Result<GltfNumbers>
    open(const tinygltf::Model& model, int accessor, std::size_t least, std::size_t most);

    /// Vectors.
    [[nodiscard]] std::size_t size() const { return _count; }
    [[nodiscard]] std::size_t components() const { return _components; }
    /// Stored as integers that can't be below zero, as what counts or names something has to be.
    [[nodiscard]] bool areUnsigned() const
    {
        return _type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
               _type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
               _type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    }

    /// A number as it is meant: integers that are said to be normalised lie between -1 and 1.
    [[nodiscard]] double at(std::size_t vector, std::size_t component) const
    {
        return _normalised ? share(vector, component) : number(vector, component);
    }
    /// The same, as if integers were normalised.
    [[nodiscard]] double share(std::size_t vector, std::size_t component) const;
    /// The same, as it is stored.
    [[nodiscard]] double number(std::size_t vector, std::size_t component) const
    {
        return _values.empty() ? stored(_bytes.data() + vector * _stride, component)
                               : _values[vector * _components + component];
    }

private:
    [[nodiscard]] double stored(const unsigned char* vector, std::size_t component) const;
    core::Result<bool> replaceSparse(const tinygltf::Model& model, const tinygltf::Accessor& from);

    std::size_t _count = 0;
    std::size_t _components = 1;
    int _type = TINYGLTF_COMPONENT_TYPE_FLOAT;
    bool _normalised = false;
    std::size_t _stride = 0; ///< [bytes]
    std::span<const unsigned char> _bytes;
    std::vector<double> _values; ///< of all vectors, where they don't stand in one place
};

} // namespace isofront::exchange
