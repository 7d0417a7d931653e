#include "isofront/voxels/ModelSource.h"

#include <zlib.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <system_error>

namespace isofront::voxels {

namespace {

tl::unexpected<core::Error> unreadable(const std::filesystem::path& file, const std::string& why)
{
    return core::failure(core::ErrorCode::inputOutput, file.string() + ": " + why);
}

core::Result<std::uint64_t> bytesOf(const std::filesystem::path& file)
{
    std::error_code failed;
    const std::uintmax_t bytes = std::filesystem::file_size(file, failed);
    if (failed)
        return unreadable(file, failed.message());
    return std::uint64_t{bytes};
}

core::Result<std::uint32_t>
checksumOf(const std::filesystem::path& file, const std::stop_token& stop = {})
{
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        return unreadable(file, std::strerror(errno));
    std::array<char, std::size_t{1} << 16U> part{};
    uLong sum = ::crc32_z(0, nullptr, 0);
    do {
        if (stop.stop_requested())
            return core::failure(
                core::ErrorCode::interrupted, file.string() + ": interrupted while it was read");
        stream.read(part.data(), static_cast<std::streamsize>(part.size()));
        sum = ::crc32_z(
            sum,
            reinterpret_cast<const Bytef*>(part.data()),
            static_cast<std::size_t>(stream.gcount()));
    } while (stream);
    if (!stream.eof())
        return unreadable(file, "can't be read to its end");
    return static_cast<std::uint32_t>(sum);
}

std::filesystem::path folderOf(const std::filesystem::path& model)
{
    std::error_code ignored;
    // absolute first: of a file that isn't there yet, a relative name would stay one
    const std::filesystem::path whole =
        std::filesystem::weakly_canonical(std::filesystem::absolute(model, ignored), ignored);
    return (whole.has_filename() ? whole : whole.parent_path()).parent_path();
}

} // namespace

core::Result<ModelSource>
describedSource(const std::filesystem::path& file, const std::filesystem::path& model)
{
    ModelSource source;
    const auto bytes = bytesOf(file);
    if (!bytes)
        return tl::unexpected(bytes.error());
    const auto checksum = checksumOf(file);
    if (!checksum)
        return tl::unexpected(checksum.error());
    source.bytes = *bytes;
    source.checksum = *checksum;
    std::error_code failed;
    const std::filesystem::path whole = std::filesystem::weakly_canonical(file, failed);
    if (failed)
        return unreadable(file, failed.message());
    const std::filesystem::path beside = whole.lexically_relative(folderOf(model));
    const bool isBelow = !beside.empty() && *beside.begin() != "..";
    source.path = (isBelow ? beside : whole).string();
    return source;
}

std::filesystem::path placeOfSource(const ModelSource& source, const std::filesystem::path& model)
{
    return folderOf(model) / source.path; // which an absolute path replaces
}

core::Result<void> checkSource(
    const ModelSource& source, const std::filesystem::path& file, const std::stop_token& stop)
{
    const auto bytes = bytesOf(file);
    if (!bytes)
        return tl::unexpected(bytes.error());
    const auto changed = [&] {
        return core::failure(
            core::ErrorCode::badData,
            file.string() + ": isn't the file that the model was made from, or has changed since");
    };
    if (*bytes != source.bytes)
        return changed();
    const auto checksum = checksumOf(file, stop);
    if (!checksum)
        return tl::unexpected(checksum.error());
    if (*checksum != source.checksum)
        return changed();
    return {};
}

} // namespace isofront::voxels
