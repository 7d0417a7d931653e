#pragma once

#include "isofront/exchange/OutputFile.h"

#include <array>
#include <bit>
#include <cstring>
#include <string_view>
#include <type_traits>

namespace isofront::exchange {

static_assert(
    std::endian::native == std::endian::little, "the binary formats are written as memory is");

/// Collects small values into blocks, because a call of OutputFile::write costs more than they do.
class BlockWriter {
public:
    explicit BlockWriter(OutputFile& file) : _file(file) {}
    BlockWriter(const BlockWriter&) = delete;
    BlockWriter& operator=(const BlockWriter&) = delete;
    ~BlockWriter() { flush(); }

    template <typename T>
    void put(const T& value)
    {
        static_assert(std::is_trivially_copyable_v<T> && sizeof(T) <= kBytes);
        if (_used + sizeof(T) > kBytes)
            flush();
        std::memcpy(_block.data() + _used, &value, sizeof(T));
        _used += sizeof(T);
    }
    void put(std::string_view text)
    {
        flush();
        _file.write(text);
    }

private:
    static constexpr std::size_t kBytes = 16384;

    void flush()
    {
        _file.write(std::span(_block.data(), _used));
        _used = 0;
    }

    OutputFile& _file;
    std::array<std::byte, kBytes> _block{};
    std::size_t _used = 0;
};

} // namespace isofront::exchange
