#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace isofront::server {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie");

/// Puts numbers behind each other, little endian and without gaps.
class ByteWriter {
public:
    template <typename Number>
    requires std::is_arithmetic_v<Number> ByteWriter& put(Number number)
    {
        return put(std::as_bytes(std::span(&number, 1)));
    }
    ByteWriter& put(std::span<const std::byte> bytes)
    {
        if (!bytes.empty()) {
            const std::size_t at = _bytes.size();
            _bytes.resize(at + bytes.size());
            std::memcpy(_bytes.data() + at, bytes.data(), bytes.size());
        }
        return *this;
    }
    /// Puts another number where one was put before.
    template <typename Number>
    requires std::is_arithmetic_v<Number>
    void replace(std::size_t at, Number number)
    {
        std::memcpy(_bytes.data() + at, &number, sizeof number);
    }

    [[nodiscard]] std::size_t size() const { return _bytes.size(); }
    [[nodiscard]] std::vector<std::byte> take() { return std::move(_bytes); }

private:
    std::vector<std::byte> _bytes;
};

/// Reads them back. Past the end everything is zero, and `isWhole` says so.
class ByteReader {
public:
    explicit ByteReader(std::span<const std::byte> bytes) : _left(bytes) {}

    template <typename Number>
    requires std::is_arithmetic_v<Number> Number get()
    {
        Number number{};
        const std::span<const std::byte> bytes = get(sizeof number);
        if (!bytes.empty())
            std::memcpy(&number, bytes.data(), sizeof number);
        return number;
    }
    /// So many bytes, or none if there are fewer.
    std::span<const std::byte> get(std::size_t count)
    {
        if (count > _left.size()) {
            _isWhole = false;
            _left = {};
            return {};
        }
        const std::span<const std::byte> bytes = _left.first(count);
        _left = _left.subspan(count);
        return bytes;
    }

    [[nodiscard]] std::size_t left() const { return _left.size(); }
    [[nodiscard]] bool isWhole() const { return _isWhole; } ///< nothing was missing so far

private:
    std::span<const std::byte> _left;
    bool _isWhole = true;
};

} // namespace isofront::server
