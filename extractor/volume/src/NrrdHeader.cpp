#include "FileHeader.h"
#include "TextHeader.h"

#include <algorithm>
#include <fstream>
#include <map>

// Source: the NRRD format, version 5 (teem.sourceforge.net/nrrd/format.html).

namespace isofront::volume {

namespace {

using core::ErrorCode;

/// Bytes of a voxel of a type that we keep; 0 for other types.
std::uint64_t bytesOfNrrdType(const std::string& type)
{
    static const std::map<std::string, std::uint64_t> kBytes = {
        {"signed char", 1},
        {"int8", 1},
        {"int8_t", 1},
        {"uchar", 1},
        {"unsigned char", 1},
        {"uint8", 1},
        {"uint8_t", 1},
        {"short", 2},
        {"short int", 2},
        {"signed short", 2},
        {"signed short int", 2},
        {"int16", 2},
        {"int16_t", 2},
        {"ushort", 2},
        {"unsigned short", 2},
        {"unsigned short int", 2},
        {"uint16", 2},
        {"uint16_t", 2},
        {"int", 4},
        {"signed int", 4},
        {"int32", 4},
        {"int32_t", 4},
        {"uint", 4},
        {"unsigned int", 4},
        {"uint32", 4},
        {"uint32_t", 4},
        {"longlong", 8},
        {"long long", 8},
        {"long long int", 8},
        {"signed long long", 8},
        {"signed long long int", 8},
        {"int64", 8},
        {"int64_t", 8},
        {"ulonglong", 8},
        {"unsigned long long", 8},
        {"unsigned long long int", 8},
        {"uint64", 8},
        {"uint64_t", 8},
        {"float", 4},
        {"double", 8}};
    const auto found = kBytes.find(type);
    return found == kBytes.end() ? 0 : found->second;
}

FileHeader::Encoding encodingFrom(const std::string& name)
{
    if (name == "raw")
        return FileHeader::Encoding::raw;
    if (name == "gz" || name == "gzip")
        return FileHeader::Encoding::deflate;
    if (name == "txt" || name == "text" || name == "ascii")
        return FileHeader::Encoding::text;
    if (name == "hex")
        return FileHeader::Encoding::hex;
    return FileHeader::Encoding::other;
}

} // namespace

core::Result<FileHeader> readNrrdHeader(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    const auto magic = readLine(file);
    if (!magic || !magic->starts_with("NRRD000"))
        return core::failure(
            ErrorCode::badData, "the file doesn't begin with \"NRRD000\", so it is no NRRD file");

    std::map<std::string, std::string> fields;
    bool isEnded = false;
    while (const auto line = readLine(file)) {
        if (const auto checked = checkLine(*line); !checked)
            return tl::unexpected(checked.error());
        const std::string_view text = trimmed(*line);
        if (text.empty()) {
            isEnded = true;
            break;
        }
        const std::size_t colon = text.find(": ");
        if (text.front() == '#' || colon == std::string_view::npos)
            continue; // a comment, or a key:=value pair
        std::string name = lowered(trimmed(text.substr(0, colon)));
        std::erase(name, ' '); // "data file" and "datafile" are the same
        fields[name] = trimmed(text.substr(colon + 1));
    }
    for (const char* needed : {"type", "dimension", "sizes", "encoding"})
        if (!fields.contains(needed))
            return core::failure(
                ErrorCode::badData, std::string("the NRRD header has no field \"") + needed + "\"");

    const auto sizes = integersFrom(fields["sizes"]);
    const auto axes = integerFrom(fields["dimension"]);
    if (!axes || !sizes || static_cast<std::int64_t>(sizes->size()) != *axes)
        return core::failure(
            ErrorCode::badData,
            "the fields \"dimension\" and \"sizes\" of the NRRD header don't "
            "name one integer for each axis");
    if (sizes->size() != 3)
        return core::failure(
            ErrorCode::badData,
            "the file has " + std::to_string(sizes->size()) +
                " axes; only three-dimensional volumes with one value a voxel can be read");

    FileHeader header;
    std::copy(sizes->begin(), sizes->end(), header.dimensions.begin());
    header.voxelBytes = bytesOfNrrdType(lowered(fields["type"]));
    if (header.voxelBytes == 0)
        return core::failure(
            ErrorCode::badData,
            "voxels of type \"" + fields["type"] +
                "\" can't be read; convert them to integers, float or double");
    header.encoding = encodingFrom(lowered(fields["encoding"]));

    if (fields.contains("datafile")) {
        const std::string& name = fields["datafile"];
        const bool isOneFile = name != "LIST" && name.find('%') == std::string::npos;
        if (isOneFile)
            header.dataFile = path.parent_path() / name; // the name alone, if it is absolute
    } else if (isEnded) {
        header.dataFile = path;
        header.dataOffset = static_cast<std::uint64_t>(file.tellg());
    } else {
        return core::failure(
            ErrorCode::badData,
            "the NRRD header is not followed by a blank line and data, and names no data file");
    }
    if (fields.contains("byteskip") && header.encoding == FileHeader::Encoding::raw) {
        // -1 means that the voxels are the last bytes of the file.
        const std::int64_t skipped = integerFrom(fields["byteskip"]).value_or(0);
        header.dataOffset += static_cast<std::uint64_t>(std::max<std::int64_t>(skipped, 0));
    }
    return header;
}

} // namespace isofront::volume
