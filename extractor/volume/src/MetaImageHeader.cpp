#include "FileHeader.h"
#include "TextHeader.h"

#include <algorithm>
#include <fstream>
#include <map>

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
        {"MET_LONG_LONG", 8},
        {"MET_ULONG_LONG", 8},
        {"MET_FLOAT", 4},
        {"MET_DOUBLE", 8}};
    const auto found = kBytes.find(type);
    return found == kBytes.end() ? 0 : found->second;
}

bool isTrue(const std::string& value)
{
    return !value.empty() && (value.front() == 'T' || value.front() == 't' || value.front() == '1');
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
        if (const auto checked = checkLine(*line); !checked)
            return tl::unexpected(checked.error());
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
                "\" can't be read; convert them to integers, float or double");

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
    header.bigEndian =
        isTrue(fields["BinaryDataByteOrderMSB"]) || isTrue(fields["ElementByteOrderMSB"]);
    if (isTrue(fields["CompressedData"])) {
        header.encoding = FileHeader::Encoding::deflate;
        const std::int64_t packed = integerFrom(fields["CompressedDataSize"]).value_or(0);
        header.packedBytes = static_cast<std::uint64_t>(std::max<std::int64_t>(packed, 0));
    }
    return header;
}

} // namespace isofront::volume
