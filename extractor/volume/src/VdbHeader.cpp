#include "VdbHeader.h"

#include <bit>
#include <fstream>
#include <optional>

static_assert(
    std::endian::native == std::endian::little, "VDB files are read as they lie in memory");

namespace isofront::volume {

namespace {

using core::ErrorCode;

/// A file from which nothing is taken that it doesn't have.
class Input {
public:
    explicit Input(const std::filesystem::path& path)
        : _stream(path, std::ios::binary), _size(std::filesystem::file_size(path))
    {
    }

    template <typename T>
    std::optional<T> number()
    {
        T value{};
        if (!_stream.read(reinterpret_cast<char*>(&value), sizeof value))
            return std::nullopt;
        return value;
    }

    bool skip(std::uint64_t bytes)
    {
        const auto position = static_cast<std::uint64_t>(_stream.tellg());
        if (!_stream || bytes > _size - position)
            return false;
        _stream.seekg(static_cast<std::streamoff>(bytes), std::ios::cur);
        return static_cast<bool>(_stream);
    }

    /// A length in 32 bits, and so many bytes.
    std::optional<std::string> text()
    {
        constexpr std::uint32_t kLongest = 1U << 16U;
        const auto length = number<std::uint32_t>();
        if (!length || *length > kLongest)
            return std::nullopt;
        std::string result(*length, '\0');
        if (!_stream.read(result.data(), static_cast<std::streamsize>(*length)))
            return std::nullopt;
        return result;
    }

    bool seek(std::uint64_t position)
    {
        if (position > _size)
            return false;
        _stream.seekg(static_cast<std::streamoff>(position));
        return static_cast<bool>(_stream);
    }

    [[nodiscard]] std::uint64_t size() const { return _size; }

private:
    std::ifstream _stream;
    std::uint64_t _size;
};

/// "name\x1e1", which makes names of one file different, reads "name[1]".
std::string readableName(const std::string& uniqueName)
{
    const std::size_t separator = uniqueName.find('\x1e');
    if (separator == std::string::npos)
        return uniqueName;
    return uniqueName.substr(0, separator) + "[" + uniqueName.substr(separator + 1) + "]";
}

bool skipMetadata(Input& input)
{
    const auto count = input.number<std::uint32_t>();
    if (!count)
        return false;
    for (std::uint32_t i = 0; i < *count; ++i) {
        const auto name = input.text();
        const auto type = input.text();
        const auto bytes = input.number<std::uint32_t>();
        if (!name || !type || !bytes || !input.skip(*bytes))
            return false;
    }
    return true;
}

tl::unexpected<core::Error> cutShort()
{
    return core::failure(
        ErrorCode::badData, "the VDB file is damaged or cut short; copy or export it again");
}

} // namespace

core::Result<std::vector<VdbGridEntry>> readVdbHeader(const std::filesystem::path& path)
{
    constexpr std::int64_t kMagic = 0x56444220;
    constexpr std::uint32_t kOldestVersion = 222;
    constexpr std::uint64_t kUuidBytes = 36;

    Input input(path);
    if (input.number<std::int64_t>() != kMagic)
        return core::failure(ErrorCode::badData, "the file doesn't begin like a VDB file");
    const auto version = input.number<std::uint32_t>();
    if (!version)
        return cutShort();
    if (*version < kOldestVersion)
        return core::failure(
            ErrorCode::badData,
            "the VDB file has format version " + std::to_string(*version) +
                "; write it again with OpenVDB 2.0 or later");
    const auto major = input.number<std::uint32_t>();
    const auto minor = input.number<std::uint32_t>();
    const auto hasIndex = input.number<char>();
    if (!major || !minor || !hasIndex || !input.skip(kUuidBytes))
        return cutShort();
    if (*hasIndex == 0)
        return core::failure(
            ErrorCode::badData,
            "the VDB file was written as a stream, without an index of its "
            "grids; write it again as a file");
    if (!skipMetadata(input))
        return cutShort();

    const auto count = input.number<std::int32_t>();
    if (!count || *count < 0)
        return cutShort();
    std::vector<VdbGridEntry> grids;
    for (std::int32_t i = 0; i < *count; ++i) {
        const auto name = input.text();
        const auto type = input.text();
        const auto parent = input.text();
        const auto begin = input.number<std::int64_t>();
        const auto blocks = input.number<std::int64_t>();
        const auto end = input.number<std::int64_t>();
        if (!name || !type || !parent || !begin || !blocks || !end || *begin < 0 ||
            *blocks < *begin || *end < *blocks || !input.seek(static_cast<std::uint64_t>(*end)))
            return cutShort();
        VdbGridEntry entry{readableName(*name), *type};
        // Grids saved with half the bits are floats again once they are read.
        constexpr std::string_view kHalf = "_HalfFloat";
        if (entry.type.ends_with(kHalf))
            entry.type.erase(entry.type.size() - kHalf.size());
        grids.push_back(std::move(entry));
    }
    return grids;
}

} // namespace isofront::volume
