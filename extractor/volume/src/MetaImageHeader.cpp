#include "FileHeader.h"
#include "TextHeader.h"

#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <map>
#include <utility>
#include <vector>

// Source: the MetaIO documentation of ITK (itk.org/Wiki/ITK/MetaIO/Documentation).

namespace isofront::volume {

namespace {

using core::ErrorCode;

/// Bytes of a voxel of a type that we keep; 0 for other types.
std::uint64_t bytesOfMetaType(const std::string& type)
{
    static const std::map<std::string, std::uint64_t> kBytes = {
        {"MET_CHAR", 1},
        {"MET_UCHAR", 1},
        {"MET_SHORT", 2},
        {"MET_USHORT", 2},
        {"MET_INT", 4},
        {"MET_UINT", 4},
        {"MET_FLOAT", 4},
        {"MET_DOUBLE", 8}};
    const auto found = kBytes.find(type);
    return found == kBytes.end() ? 0 : found->second;
}

bool isTrue(const std::string& value)
{
    return !value.empty() && (value.front() == 'T' || value.front() == 't' || value.front() == '1');
}

/// How many bytes a zlib or gzip stream unpacks to, as far as it is whole; stops beyond `most`.
/// @param packedBytes  what may be read of the stream
std::uint64_t inflatedBytes(std::istream& stream, std::uint64_t packedBytes, std::uint64_t most)
{
    constexpr std::size_t kChunk = std::size_t{1} << 18U;
    std::vector<unsigned char> packed(kChunk);
    std::vector<unsigned char> unpacked(kChunk);
    z_stream inflater{};
    constexpr int kZlibOrGzip = MAX_WBITS + 32;
    if (inflateInit2(&inflater, kZlibOrGzip) != Z_OK)
        return 0;
    std::uint64_t total = 0;
    int state = Z_OK;
    while (state == Z_OK && total < most) {
        if (inflater.avail_in == 0) {
            stream.read(
                reinterpret_cast<char*>(packed.data()),
                static_cast<std::streamsize>(std::min<std::uint64_t>(kChunk, packedBytes)));
            inflater.next_in = packed.data();
            inflater.avail_in = static_cast<uInt>(stream.gcount());
            if (inflater.avail_in == 0)
                break;
            packedBytes -= inflater.avail_in;
        }
        inflater.next_out = unpacked.data();
        inflater.avail_out = static_cast<uInt>(kChunk);
        state = inflate(&inflater, Z_NO_FLUSH);
        total += kChunk - inflater.avail_out;
    }
    inflateEnd(&inflater);
    return total;
}

} // namespace

core::Result<FileHeader> readMetaImageHeader(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    std::map<std::string, std::string> fields;
    while (!fields.contains("ElementDataFile")) {
        const auto line = readLine(file);
        const std::size_t sign = line ? line->find('=') : std::string::npos;
        if (sign == std::string::npos)
            return core::failure(
                ErrorCode::badData,
                "the file has no MetaImage header, which is lines of \"key = "
                "value\" up to ElementDataFile");
        fields[std::string(trimmed(line->substr(0, sign)))] = trimmed(line->substr(sign + 1));
    }

    FileHeader header;
    const auto axes = integerFrom(fields["NDims"]);
    const auto sizes = integersFrom(fields["DimSize"]);
    if (!axes || !sizes || static_cast<std::int64_t>(sizes->size()) != *axes)
        return core::failure(
            ErrorCode::badData,
            "NDims and DimSize of the MetaImage header don't name one integer for each axis");
    const auto channels =
        fields.contains("ElementNumberOfChannels") ? fields["ElementNumberOfChannels"] : "1";
    if (sizes->size() != 3 || channels != "1")
        return core::failure(
            ErrorCode::badData,
            "the file has " + std::to_string(sizes->size()) + " axes and " + channels +
                " values a voxel; only three-dimensional volumes with one "
                "value a voxel can be read");
    std::copy(sizes->begin(), sizes->end(), header.dimensions.begin());
    header.voxelBytes = bytesOfMetaType(fields["ElementType"]);
    if (header.voxelBytes == 0)
        return core::failure(
            ErrorCode::badData,
            "voxels of type \"" + fields["ElementType"] +
                "\" can't be read; convert them to integers of at most 32 "
                "bits, float or double");

    const std::string& name = fields["ElementDataFile"];
    if (lowered(name) == "local") {
        header.dataFile = path;
        header.dataOffset = static_cast<std::uint64_t>(file.tellg());
    } else if (name.starts_with("LIST") || name.find('%') != std::string::npos) {
        return core::failure(
            ErrorCode::badData,
            "the voxels are spread over several files; convert them to one file");
    } else {
        header.dataFile = path.parent_path() / name; // the name alone, if it is absolute
    }
    // -1 means that the voxels are the last bytes of the file.
    const std::int64_t skipped = integerFrom(fields["HeaderSize"]).value_or(0);
    header.dataOffset += static_cast<std::uint64_t>(std::max<std::int64_t>(skipped, 0));
    if (fields.contains("BinaryData") && !isTrue(fields["BinaryData"]))
        return core::failure(
            ErrorCode::badData, "the voxels are written as text; convert them to binary");
    if (isTrue(fields["CompressedData"])) {
        header.encoding = FileHeader::Encoding::deflate;
        const std::int64_t packed = integerFrom(fields["CompressedDataSize"]).value_or(0);
        header.packedBytes = static_cast<std::uint64_t>(std::max<std::int64_t>(packed, 0));
    }
    return header;
}

core::Result<void> checkMetaImageData(const FileHeader& header)
{
    if (header.encoding != FileHeader::Encoding::deflate)
        return {};
    std::ifstream file(header.dataFile, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(header.dataOffset));
    const std::uint64_t packed =
        header.packedBytes > 0 ? header.packedBytes : std::numeric_limits<std::uint64_t>::max();
    const std::uint64_t whole = inflatedBytes(file, packed, header.dataBytes());
    if (whole < header.dataBytes())
        return core::failure(
            ErrorCode::badData,
            "the compressed data are damaged or cut short: they unpack to " +
                std::to_string(whole) + " of " + std::to_string(header.dataBytes()) + " bytes");
    return {};
}

} // namespace isofront::volume
