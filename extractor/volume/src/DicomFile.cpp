#include "DicomFile.h"

#include "DicomRuns.h"
#include "TextHeader.h"

#include <isofront/core/Assert.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

namespace isofront::volume {

namespace {

using core::ErrorCode;
using core::failure;

constexpr std::uint32_t kUndefined = 0xffffffff;
constexpr std::uint32_t kPixelData = 0x7fe00010;
constexpr std::uint32_t kItem = 0xfffee000;
constexpr std::uint32_t kItemEnd = 0xfffee00d;
constexpr std::uint32_t kSequenceEnd = 0xfffee0dd;
constexpr int kDeepest = 16;                  // of sequences in sequences
constexpr std::uint32_t kLongestValue = 4096; // of what is wanted here

tl::unexpected<core::Error> damaged()
{
    return failure(
        ErrorCode::badData, "its DICOM data elements are damaged or cut short; get it again");
}

/// How the elements of a file are written.
struct Syntax {
    bool isExplicit = true; ///< with the kind of each value
    bool bigEndian = false;
    bool hasRuns = false; ///< pixels are packed as runs of bytes
};

struct Element {
    std::uint32_t tag = 0;
    std::array<char, 2> kind{'U', 'N'};
    std::uint32_t length = 0;
};

/// Walks over the data elements of a file.
class Reader {
public:
    explicit Reader(const std::filesystem::path& path) : _file(path, std::ios::binary)
    {
        std::error_code failed;
        const std::uintmax_t size = std::filesystem::file_size(path, failed);
        _size = failed ? 0 : size;
    }

    [[nodiscard]] std::uint64_t position() const { return _position; }
    [[nodiscard]] std::uint64_t left() const { return _size - _position; }

    bool skip(std::uint64_t bytes)
    {
        if (bytes > left())
            return false;
        _position += bytes;
        _file.seekg(static_cast<std::streamoff>(_position));
        return true;
    }
    bool read(char* into, std::size_t bytes)
    {
        if (bytes > left() || !_file.read(into, static_cast<std::streamsize>(bytes)))
            return false;
        _position += bytes;
        return true;
    }
    template <typename T>
    std::optional<T> number(bool bigEndian)
    {
        std::array<char, sizeof(T)> bytes{};
        if (!read(bytes.data(), bytes.size()))
            return std::nullopt;
        T value = 0;
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            const auto byte =
                static_cast<unsigned char>(bytes[bigEndian ? bytes.size() - 1 - i : i]);
            value = static_cast<T>(value | static_cast<T>(T{byte} << (8 * i)));
        }
        return value;
    }

    std::optional<Element> element(const Syntax& syntax)
    {
        const auto group = number<std::uint16_t>(syntax.bigEndian);
        const auto part = number<std::uint16_t>(syntax.bigEndian);
        if (!group || !part)
            return std::nullopt;
        Element element;
        element.tag = (std::uint32_t{*group} << 16U) | *part;
        const bool isDelimiter = *group == 0xfffe; // these never have a kind
        if (syntax.isExplicit && !isDelimiter) {
            if (!read(element.kind.data(), 2))
                return std::nullopt;
            static constexpr std::string_view kLong = "OB OW OF OD OL OV SQ UN UC UR UT SV UV";
            const std::string_view kind(element.kind.data(), 2);
            if (kLong.find(kind) == std::string_view::npos) {
                const auto length = number<std::uint16_t>(syntax.bigEndian);
                if (!length)
                    return std::nullopt;
                element.length = *length;
                return element;
            }
            if (!skip(2))
                return std::nullopt;
        }
        const auto length = number<std::uint32_t>(syntax.bigEndian);
        if (!length)
            return std::nullopt;
        element.length = *length;
        return element;
    }

    /// Goes beyond the value of an element, sequences of unknown length included.
    bool skipValue(const Element& element, const Syntax& syntax, int depth = 0)
    {
        if (element.length != kUndefined)
            return skip(element.length);
        if (depth > kDeepest)
            return false;
        // what is of unknown kind and length is written without kinds
        const bool isUnknown = element.kind == std::array{'U', 'N'};
        const Syntax inner{syntax.isExplicit && !isUnknown, syntax.bigEndian};
        while (const auto item = this->element(inner)) {
            if (item->tag == kSequenceEnd)
                return true;
            if (item->tag != kItem)
                return false;
            if (item->length != kUndefined) {
                if (!skip(item->length))
                    return false;
                continue;
            }
            while (true) {
                const auto nested = this->element(inner);
                if (!nested)
                    return false;
                if (nested->tag == kItemEnd)
                    break;
                if (!skipValue(*nested, inner, depth + 1))
                    return false;
            }
        }
        return false;
    }

private:
    std::ifstream _file;
    std::uint64_t _size = 0;
    std::uint64_t _position = 0;
};

/// The values that are wanted, by tag, as they stand in the file.
class Values {
public:
    std::map<std::uint32_t, std::string> raw;
    bool bigEndian = false;

    [[nodiscard]] std::string text(std::uint32_t tag) const
    {
        const auto found = raw.find(tag);
        if (found == raw.end())
            return {};
        std::string value = found->second;
        std::erase(value, '\0');
        return std::string(trimmed(value));
    }
    [[nodiscard]] std::optional<int> number(std::uint32_t tag) const
    {
        const auto found = raw.find(tag);
        if (found == raw.end() || found->second.size() < 2)
            return std::nullopt;
        const auto first = static_cast<unsigned char>(found->second[0]);
        const auto second = static_cast<unsigned char>(found->second[1]);
        return bigEndian ? first * 256 + second : second * 256 + first;
    }
    /// Decimal numbers with backslashes between them; empty if any is none or not finite.
    [[nodiscard]] std::vector<double> decimals(std::uint32_t tag) const
    {
        std::vector<double> numbers;
        const std::string all = text(tag);
        for (std::size_t begin = 0; begin <= all.size() && !all.empty();) {
            const std::size_t end = std::min(all.find('\\', begin), all.size());
            std::string_view part = trimmed(std::string_view(all).substr(begin, end - begin));
            if (part.starts_with('+'))
                part.remove_prefix(1);
            double value = 0;
            const auto [stop, error] =
                std::from_chars(part.data(), part.data() + part.size(), value);
            if (error != std::errc() || stop != part.data() + part.size() || !std::isfinite(value))
                return {};
            numbers.push_back(value);
            begin = end + 1;
        }
        return numbers;
    }
};

bool isWanted(std::uint32_t tag)
{
    constexpr std::array<std::uint32_t, 18> kWanted{
        0x0008103e,
        0x0020000e,
        0x00200032,
        0x00200037,
        0x00280002,
        0x00280004,
        0x00280008,
        0x00280010,
        0x00280011,
        0x00280030,
        0x00280100,
        0x00280101,
        0x00280102,
        0x00280103,
        0x00281052,
        0x00281053,
        0x00020010,
        0x00180088};
    return std::find(kWanted.begin(), kWanted.end(), tag) != kWanted.end();
}

/// Reads elements until the pixels, or until the first one that is not in this group.
/// @return the element that it stopped at, its value unread
core::Result<Element>
readValues(Reader& reader, const Syntax& syntax, std::uint16_t onlyGroup, Values& values)
{
    while (true) {
        const std::uint64_t begin = reader.position();
        const auto element = reader.element(syntax);
        if (!element)
            return damaged();
        if (onlyGroup != 0 && element->tag >> 16U != onlyGroup) {
            // it belongs to what comes next, which is written in another way
            return Element{0, {}, static_cast<std::uint32_t>(begin)};
        }
        if (element->tag == kPixelData)
            return *element;
        if (isWanted(element->tag) && element->length <= kLongestValue) {
            std::string value(element->length, '\0');
            if (!reader.read(value.data(), value.size()))
                return damaged();
            values.raw.emplace(element->tag, std::move(value));
        } else if (!reader.skipValue(*element, syntax)) {
            return damaged();
        }
    }
}

core::Result<Syntax> syntaxNamed(const std::string& name)
{
    if (name == "1.2.840.10008.1.2")
        return Syntax{false, false};
    if (name == "1.2.840.10008.1.2.1")
        return Syntax{true, false};
    if (name == "1.2.840.10008.1.2.2")
        return Syntax{true, true};
    if (name == "1.2.840.10008.1.2.5")
        return Syntax{true, false, true};
    struct Packing {
        std::string_view name;
        std::string_view words;
    };
    // PS3.6, table A-1: what stands behind 1.2.840.10008.1.2.
    static constexpr std::array<Packing, 14> kPackings{
        {{"1.99", "deflated"},
         {"4.50", "JPEG, 8 bits with losses"},
         {"4.51", "JPEG, 12 bits with losses"},
         {"4.57", "JPEG without losses"},
         {"4.70", "JPEG without losses"},
         {"4.80", "JPEG-LS without losses"},
         {"4.81", "JPEG-LS"},
         {"4.90", "JPEG 2000 without losses"},
         {"4.91", "JPEG 2000"},
         {"4.100", "MPEG-2"},
         {"4.102", "MPEG-4"},
         {"4.201", "high-throughput JPEG 2000 without losses"},
         {"4.202", "high-throughput JPEG 2000"},
         {"4.203", "high-throughput JPEG 2000"}}};
    constexpr std::string_view kRoot = "1.2.840.10008.1.2.";
    std::string words = "in a way unknown here";
    for (const Packing& packing : kPackings)
        if (name.starts_with(kRoot) && name.substr(kRoot.size()) == packing.name)
            words = packing.words;
    const bool isName =
        name.find_first_not_of("0123456789.") == std::string::npos && name.size() <= 64;
    return failure(
        ErrorCode::badData,
        "its pixels are compressed (" + words + ", transfer syntax " +
            (isName && !name.empty() ? name : "not named") +
            "); unpack the series first, as with gdcmconv --raw or dcmdjpeg");
}

/// Fills in what the elements say; fails if they don't describe a slice.
core::Result<void> describe(const Values& values, DicomFile& file)
{
    const auto refused = [](const std::string& why) { return failure(ErrorCode::badData, why); };
    if (values.number(0x00280002).value_or(1) != 1)
        return refused("it has several numbers a pixel, as colours");
    const std::vector<double> frames = values.decimals(0x00280008);
    if (!frames.empty() && frames[0] > 1)
        return refused("it has several frames; write each to a file of its own");
    file.columns = values.number(0x00280011).value_or(0);
    file.rows = values.number(0x00280010).value_or(0);
    file.bitsAllocated = values.number(0x00280100).value_or(0);
    file.bitsStored = values.number(0x00280101).value_or(file.bitsAllocated);
    const int highBit = values.number(0x00280102).value_or(file.bitsStored - 1);
    file.isSigned = values.number(0x00280103).value_or(0) == 1;
    const bool isWhole =
        file.bitsAllocated == 8 || file.bitsAllocated == 16 || file.bitsAllocated == 32;
    if (file.columns < 1 || file.rows < 1 || !isWhole || file.bitsStored < 1 ||
        file.bitsStored > file.bitsAllocated || highBit != file.bitsStored - 1)
        return refused(
            "its pixels, " + std::to_string(file.columns) + " x " + std::to_string(file.rows) +
            " of " + std::to_string(file.bitsStored) + " in " + std::to_string(file.bitsAllocated) +
            " bits, can't be read");
    const auto one = [&](std::uint32_t tag, double otherwise) {
        const std::vector<double> numbers = values.decimals(tag);
        return numbers.size() == 1 ? numbers[0] : otherwise;
    };
    file.slope = one(0x00281053, 1);
    file.intercept = one(0x00281052, 0);
    const std::vector<double> position = values.decimals(0x00200032);
    const std::vector<double> axes = values.decimals(0x00200037);
    const std::vector<double> spacing = values.decimals(0x00280030);
    if (position.size() != 3 || axes.size() != 6 || spacing.size() != 2 || !(spacing[0] > 0) ||
        !(spacing[1] > 0) || file.slope == 0)
        return refused("it doesn't say where in space its pixels lie");
    file.position = {position[0], position[1], position[2]};
    file.alongRow = {axes[0], axes[1], axes[2]};
    file.alongColumn = {axes[3], axes[4], axes[5]};
    const bool isUpright = std::abs(glm::length(file.alongRow) - 1) < 0.01 &&
                           std::abs(glm::length(file.alongColumn) - 1) < 0.01 &&
                           std::abs(glm::dot(file.alongRow, file.alongColumn)) < 0.01;
    if (!isUpright)
        return refused("its axes are no unit vectors at a right angle");
    file.alongRow = glm::normalize(file.alongRow);
    file.alongColumn = glm::normalize(file.alongColumn);
    file.rowSpacing = spacing[0];
    file.columnSpacing = spacing[1];
    file.series = values.text(0x0020000e);
    file.description = values.text(0x0008103e);
    return {};
}

/// Finds the pixels' one fragment: behind an item with offsets, and before the end of the sequence.
core::Result<DicomFile> withRuns(DicomFile file, Reader& data, std::uint64_t needed)
{
    // A run makes 128 bytes of two, so that a small file can't ask for much memory.
    constexpr std::uint64_t kMostGrowth = 64;
    constexpr Syntax kItems{true, false};
    const auto offsets = data.element(kItems);
    if (!offsets || offsets->tag != kItem || !data.skip(offsets->length))
        return damaged();
    const auto fragment = data.element(kItems);
    if (!fragment || fragment->tag != kItem)
        return damaged();
    file.pixelOffset = data.position();
    file.packedBytes = fragment->length;
    if (!data.skip(fragment->length))
        return damaged();
    const auto end = data.element(kItems);
    if (!end || end->tag != kSequenceEnd || file.packedBytes == 0 ||
        needed / kMostGrowth > file.packedBytes)
        return damaged();
    return file;
}

} // namespace

core::Result<DicomFile> readDicomHeader(const std::filesystem::path& path)
{
    Reader reader(path);
    std::array<char, 4> magic{};
    if (!reader.skip(128) || !reader.read(magic.data(), 4) ||
        std::string_view(magic.data(), 4) != "DICM")
        return failure(ErrorCode::badData, "it is no DICOM file");
    Values values;
    const auto meta = readValues(reader, {}, 2, values);
    if (!meta)
        return tl::unexpected(meta.error());
    const auto syntax = syntaxNamed(values.text(0x00020010));
    if (!syntax)
        return tl::unexpected(syntax.error());
    values.bigEndian = syntax->bigEndian;

    // back to the first element that is not of the file's own group
    Reader data(path);
    if (!data.skip(meta->length))
        return damaged();
    const auto pixels = readValues(data, *syntax, 0, values);
    if (!pixels)
        return tl::unexpected(pixels.error());
    DicomFile file;
    file.path = path;
    file.bigEndian = syntax->bigEndian;
    if (const auto described = describe(values, file); !described)
        return tl::unexpected(described.error());
    file.pixelOffset = data.position();
    const std::uint64_t needed =
        std::uint64_t{file.pixels()} * static_cast<std::uint64_t>(file.bitsAllocated / 8);
    if (syntax->hasRuns) {
        if (pixels->length != kUndefined)
            return damaged();
        return withRuns(std::move(file), data, needed);
    }
    if (pixels->length == kUndefined || needed > pixels->length || needed > data.left())
        return failure(
            ErrorCode::badData,
            "its pixels are cut short: " + std::to_string(needed) + " bytes are promised, " +
                std::to_string(std::min<std::uint64_t>(pixels->length, data.left())) +
                " are there");
    return file;
}

core::Result<void> readDicomPixels(const DicomFile& file, std::span<std::int64_t> into)
{
    ISOFRONT_ASSERT(into.size() == file.pixels(), "there must be room for every pixel");
    const auto size = static_cast<std::size_t>(file.bitsAllocated / 8);
    std::vector<char> bytes(into.size() * size);
    std::vector<char> packed(static_cast<std::size_t>(file.packedBytes));
    std::vector<char>& stored = packed.empty() ? bytes : packed;
    std::ifstream stream(file.path, std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(file.pixelOffset));
    if (!stream.read(stored.data(), static_cast<std::streamsize>(stored.size())))
        return failure(
            ErrorCode::inputOutput,
            file.path.filename().string() + " can't be read; it changed or went away");
    if (!packed.empty())
        if (const auto unpacked = unpackDicomRuns(packed, size, bytes); !unpacked)
            return failure(
                unpacked.error().code,
                file.path.filename().string() + ": " + unpacked.error().message);
    const auto unused = static_cast<unsigned>(64 - file.bitsStored);
    for (std::size_t i = 0; i < into.size(); ++i) {
        std::uint64_t value = 0;
        for (std::size_t byte = 0; byte < size; ++byte) {
            const std::size_t at = i * size + (file.bigEndian ? size - 1 - byte : byte);
            value |= std::uint64_t{static_cast<unsigned char>(bytes[at])} << (8 * byte);
        }
        // Only the stored bits count; shifting them up and down again carries the sign along.
        value <<= unused;
        into[i] = file.isSigned ? static_cast<std::int64_t>(value) >> unused
                                : static_cast<std::int64_t>(value >> unused);
    }
    return {};
}

} // namespace isofront::volume
