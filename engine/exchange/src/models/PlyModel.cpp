// Based on: Turk, "The PLY Polygon File Format", 1994.

#include "ModelBudget.h"
#include "ModelFormats.h"
#include "TextScanner.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace isofront::exchange {

namespace {

enum class Number { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
constexpr std::array<std::array<std::string_view, 2>, 8> kNames{
    {{"char", "int8"},
     {"uchar", "uint8"},
     {"short", "int16"},
     {"ushort", "uint16"},
     {"int", "int32"},
     {"uint", "uint32"},
     {"float", "float32"},
     {"double", "float64"}}};

std::optional<Number> numberTypeOf(std::string_view name)
{
    for (std::size_t i = 0; i < kNames.size(); ++i)
        if (name == kNames[i][0] || name == kNames[i][1])
            return static_cast<Number>(i);
    return std::nullopt;
}

struct Property {
    std::string name;
    Number type = Number::float32;
    std::optional<Number> count; ///< of lists: the type of their length
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

enum class Encoding { text, littleEndian, bigEndian };

struct PlyHeader {
    Encoding encoding = Encoding::text;
    std::vector<Element> elements;
    std::size_t end = 0; ///< where the data begin
};

core::Error damaged(const std::string& what)
{
    return {core::ErrorCode::badData, what};
}

core::Result<PlyHeader> readHeader(TextScanner& text)
{
    PlyHeader header;
    if (!text.nextLine() || text.word() != "ply")
        return tl::unexpected(damaged("it doesn't begin with 'ply'"));
    bool hasFormat = false;
    while (text.nextLine()) {
        const std::string_view key = text.word();
        if (key == "end_header") {
            if (!hasFormat)
                return tl::unexpected(damaged("its header names no format"));
            header.end = text.position();
            return header;
        }
        if (key == "format") {
            const std::string_view format = text.word();
            hasFormat = true;
            if (format == "ascii")
                header.encoding = Encoding::text;
            else if (format == "binary_little_endian")
                header.encoding = Encoding::littleEndian;
            else if (format == "binary_big_endian")
                header.encoding = Encoding::bigEndian;
            else
                return tl::unexpected(damaged(text.at("the format is unknown")));
        } else if (key == "element") {
            Element element;
            element.name = text.word();
            const auto count = text.number<std::uint64_t>();
            if (!count)
                return tl::unexpected(damaged(text.at("an element needs a name and a number")));
            element.count = *count;
            header.elements.push_back(std::move(element));
        } else if (key == "property") {
            if (header.elements.empty())
                return tl::unexpected(damaged(text.at("a property comes before any element")));
            Property property;
            std::string_view type = text.word();
            if (type == "list") {
                property.count = numberTypeOf(text.word());
                type = text.word();
                if (!property.count)
                    return tl::unexpected(damaged(text.at("a list's length has no known type")));
            }
            const auto known = numberTypeOf(type);
            if (!known)
                return tl::unexpected(damaged(text.at("a property has no known type")));
            property.type = *known;
            property.name = text.word();
            header.elements.back().properties.push_back(std::move(property));
        }
        // comments, and what nobody knows, say nothing about the data
    }
    return tl::unexpected(damaged("its header has no end"));
}

/// Numbers in the order of the file, whatever their encoding.
class Numbers {
public:
    Numbers(std::span<const std::byte> bytes, const PlyHeader& header)
        : _encoding(header.encoding), _bytes(bytes.subspan(header.end)), _text(_bytes)
    {
    }

    /// Begins an element: a line, in text.
    bool begin() { return _encoding != Encoding::text || nextFullLine(); }

    std::optional<double> next(Number type)
    {
        if (_encoding == Encoding::text) {
            const std::string_view word = _isFirst ? std::exchange(_first, {}) : _text.word();
            _isFirst = false;
            return TextScanner::numberOf<double>(word);
        }
        const std::size_t size = kSizes[static_cast<std::size_t>(type)];
        if (_bytes.size() - _at < size)
            return std::nullopt;
        std::array<std::byte, 8> raw{};
        std::memcpy(raw.data(), _bytes.data() + _at, size);
        _at += size;
        if ((_encoding == Encoding::bigEndian) == (std::endian::native == std::endian::little))
            std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
        switch (type) {
        case Number::int8:
            return as<std::int8_t>(raw);
        case Number::uint8:
            return as<std::uint8_t>(raw);
        case Number::int16:
            return as<std::int16_t>(raw);
        case Number::uint16:
            return as<std::uint16_t>(raw);
        case Number::int32:
            return as<std::int32_t>(raw);
        case Number::uint32:
            return as<std::uint32_t>(raw);
        case Number::float32:
            return static_cast<double>(as<float>(raw));
        case Number::float64:
            return as<double>(raw);
        }
        return std::nullopt;
    }
    /// How many bytes of the data have been read.
    [[nodiscard]] std::size_t position() const
    {
        return _encoding == Encoding::text ? _text.position() : _at;
    }
    /// The least that so many numbers of the smallest kind would take is no more than what is left.
    [[nodiscard]] bool canHold(std::uint64_t count) const
    {
        return count <= _bytes.size() - (_encoding == Encoding::text ? 0 : _at);
    }

private:
    template <typename T>
    static T as(const std::array<std::byte, 8>& raw)
    {
        T value{};
        std::memcpy(&value, raw.data(), sizeof(T));
        return value;
    }
    /// Empty lines are passed over.
    bool nextFullLine()
    {
        while (_text.nextLine()) {
            _first = _text.word();
            if (!_first.empty()) {
                _isFirst = true;
                return true;
            }
        }
        return false;
    }

    Encoding _encoding;
    std::span<const std::byte> _bytes;
    TextScanner _text;
    std::string_view _first;
    bool _isFirst = false;
    std::size_t _at = 0;
};

/// Where a property of a vertex goes.
int placeOf(const Property& property)
{
    constexpr std::array<std::string_view, 7> kPlaces{
        "x", "y", "z", "red", "green", "blue", "alpha"};
    const auto found = std::ranges::find(kPlaces, property.name);
    return property.count || found == kPlaces.end() ? -1
                                                    : static_cast<int>(found - kPlaces.begin());
}

/// 8 bits of a colour, which files give as integers to 255, or as reals to 1.
std::uint32_t colourCode(double value, Number type)
{
    const bool isReal = type == Number::float32 || type == Number::float64;
    const double scaled = isReal ? 255 * value : type == Number::uint16 ? value / 257 : value;
    return scaled >= 0 ? static_cast<std::uint32_t>(std::lround(std::min(scaled, 255.0))) : 0;
}

/// Makes triangles of a polygon's corners, or of a strip's, which -1 ends.
struct Corners {
    voxels::TriangleModel& model;
    bool isStrip;
    std::uint64_t count = 0;
    std::uint32_t first = 0;
    std::uint32_t last = 0;

    void add(double value)
    {
        if (isStrip && value < 0) {
            count = 0;
            return;
        }
        // what is no index becomes one that nothing has
        const std::uint32_t corner =
            value >= 0 && value < 4294967295.0 ? static_cast<std::uint32_t>(value) : 0xffffffffU;
        if (count == 0)
            first = corner;
        else if (count > 1 && (!isStrip || count % 2 == 0))
            model.triangles.push_back({first, last, corner});
        else if (count > 1)
            model.triangles.push_back({last, first, corner}); // every other is turned
        if (isStrip && count > 0)
            first = last;
        last = corner;
        ++count;
    }
};

class PlyReader {
public:
    PlyReader(
        std::span<const std::byte> bytes, const PlyHeader& header, const ModelContext& context)
        : _header(header), _numbers(bytes, header), _budget(context.mostBytes), _context(context)
    {
    }

    core::Result<voxels::TriangleModel> run()
    {
        for (const Element& element : _header.elements) {
            if (!_numbers.canHold(element.count))
                return tl::unexpected(tooShort(element));
            const bool isVertex = element.name == "vertex";
            const bool isFace = element.name == "face" || element.name == "tristrips";
            if (isVertex || isFace)
                reserve(isVertex, element.count);
            for (std::uint64_t i = 0; i < element.count; ++i) {
                if (i % kElementsBetween == 0 && _context.passed)
                    _context.passed(_header.end + _numbers.position());
                if (!_numbers.begin())
                    return tl::unexpected(tooShort(element));
                const bool done = isVertex ? readVertex(element)
                                  : isFace ? readFace(element)
                                           : skip(element);
                if (auto failed = _budget.check(_model))
                    return tl::unexpected(*failed);
                if (!done)
                    return tl::unexpected(damaged(
                        element.name + " " + std::to_string(i) + " of " +
                        std::to_string(element.count) + " is cut short, or not a number"));
            }
            if (isVertex && !_hasPlace)
                return tl::unexpected(damaged("its vertices have no x, y and z"));
        }
        return std::move(_model);
    }

private:
    /// How many elements are read before bytes are passed.
    static constexpr std::uint64_t kElementsBetween = 1U << 16U;

    /// Growing little by little, positions and triangles would take up to thrice as much. No more
    /// than what is allowed and what a file of that length can hold.
    void reserve(bool isVertex, std::uint64_t count)
    {
        constexpr std::uint64_t kLeastBytes = 3; // of either, in any encoding
        if (!_numbers.canHold(kLeastBytes * count))
            return;
        if (isVertex && !_budget.check(_model, {.positions = count}))
            _model.positions.reserve(_model.positions.size() + count);
        if (!isVertex && !_budget.check(_model, {.triangles = count}))
            _model.triangles.reserve(_model.triangles.size() + count);
    }
    static core::Error tooShort(const Element& element)
    {
        return damaged(
            "it ends before its " + std::to_string(element.count) + " elements '" + element.name +
            "' do");
    }

    bool readVertex(const Element& element)
    {
        glm::dvec3 position(0);
        std::array<std::uint32_t, 4> colour{0, 0, 0, 255};
        unsigned given = 0;
        for (const Property& property : element.properties) {
            if (property.count) {
                if (!skipList(property))
                    return false;
                continue;
            }
            const auto value = _numbers.next(property.type);
            if (!value)
                return false;
            const int place = placeOf(property);
            if (place < 0)
                continue;
            given |= 1U << static_cast<unsigned>(place);
            if (place < 3)
                position[static_cast<std::size_t>(place)] = *value;
            else
                colour[static_cast<std::size_t>(place - 3)] = colourCode(*value, property.type);
        }
        _hasPlace = (given & 7U) == 7U;
        _model.positions.push_back(position);
        if ((given & 0x38U) == 0x38U)
            _model.colours.push_back(
                colour[0] | colour[1] << 8U | colour[2] << 16U | colour[3] << 24U);
        return true;
    }

    bool readFace(const Element& element)
    {
        for (const Property& property : element.properties) {
            const bool isCorners = property.count && (property.name == "vertex_indices" ||
                                                      property.name == "vertex_index");
            if (!isCorners) {
                if (property.count ? !skipList(property) : !_numbers.next(property.type))
                    return false;
                continue;
            }
            const auto count = _numbers.next(*property.count);
            if (!count || !(*count >= 0) || *count > 1e9 ||
                !_numbers.canHold(static_cast<std::uint64_t>(*count)))
                return false;
            Corners corners{_model, element.name == "tristrips"};
            for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(*count); ++i) {
                const auto value = _numbers.next(property.type);
                if (!value)
                    return false;
                corners.add(*value);
                if (_budget.check(_model)) // a list may be as long as the file
                    return false;
            }
        }
        return true;
    }

    bool skip(const Element& element)
    {
        return std::ranges::all_of(element.properties, [&](const Property& property) {
            return property.count ? skipList(property) : _numbers.next(property.type).has_value();
        });
    }
    bool skipList(const Property& property)
    {
        const auto count = _numbers.next(*property.count);
        if (!count || !(*count >= 0) || *count > 1e9 ||
            !_numbers.canHold(static_cast<std::uint64_t>(*count)))
            return false;
        for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(*count); ++i)
            if (!_numbers.next(property.type))
                return false;
        return true;
    }

    const PlyHeader& _header;
    Numbers _numbers;
    ModelBudget _budget;
    const ModelContext& _context;
    voxels::TriangleModel _model;
    bool _hasPlace = false;
};

} // namespace

core::Result<voxels::TriangleModel>
readPly(std::span<const std::byte> bytes, const ModelContext& context)
{
    TextScanner text(bytes);
    const auto header = readHeader(text);
    if (!header)
        return tl::unexpected(header.error());
    auto model = PlyReader(bytes, *header, context).run();
    if (model && model->colours.size() != model->positions.size())
        model->colours.clear();
    return model;
}

} // namespace isofront::exchange
