// Based on: 3D Systems, "Stereolithography Interface Specification", 1989.

#include "ModelBudget.h"
#include "ModelFormats.h"
#include "TextScanner.h"

#include <bit>
#include <cstring>
#include <optional>
#include <unordered_map>

namespace isofront::exchange {

namespace {

constexpr std::size_t kHeader = 84;   ///< of binary files, with the number of triangles
constexpr std::size_t kTriangle = 50; ///< normal, corners, and two bytes that nobody uses

struct PlaceHash {
    std::size_t operator()(const std::array<std::uint64_t, 3>& bits) const
    {
        std::uint64_t hash = 0;
        for (const std::uint64_t part : bits) {
            hash = (hash ^ part) * 0x9e3779b97f4a7c15U;
            hash ^= hash >> 29U;
        }
        return static_cast<std::size_t>(hash);
    }
};

/// Collects corners; those at equal places become one.
class Corners {
public:
    explicit Corners(std::uint64_t mostBytes) : _budget(mostBytes) {}

    /// What is wrong with adding it, if anything is.
    std::optional<core::Error> add(const glm::dvec3& position)
    {
        // + 0.0: both zeros are one place
        const std::array<std::uint64_t, 3> bits{
            std::bit_cast<std::uint64_t>(position.x + 0.0),
            std::bit_cast<std::uint64_t>(position.y + 0.0),
            std::bit_cast<std::uint64_t>(position.z + 0.0)};
        const auto [entry, isNew] =
            _indices.try_emplace(bits, static_cast<std::uint32_t>(_model.positions.size()));
        if (isNew)
            _model.positions.push_back(position);
        _triangle[_count++] = entry->second;
        if (_count == 3) {
            _model.triangles.push_back(_triangle);
            _count = 0;
        }
        return _budget.check(_model, {.otherBytes = _indices.size() * kEntryBytes});
    }
    [[nodiscard]] bool isWhole() const { return _count == 0; }
    voxels::TriangleModel take() { return std::move(_model); }

private:
    /// Of a place in the map: it, its index, and, at the least, a hash and two pointers.
    static constexpr std::uint64_t kEntryBytes = 56;

    ModelBudget _budget;
    voxels::TriangleModel _model;
    std::unordered_map<std::array<std::uint64_t, 3>, std::uint32_t, PlaceHash> _indices;
    std::array<std::uint32_t, 3> _triangle{};
    std::size_t _count = 0;
};

core::Error damaged(const std::string& what)
{
    return {core::ErrorCode::badData, what};
}

std::uint32_t countOf(std::span<const std::byte> bytes)
{
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < 4; ++i)
        count |= static_cast<std::uint32_t>(bytes[80 + i]) << 8 * i;
    return count;
}

core::Result<voxels::TriangleModel>
readBinary(std::span<const std::byte> bytes, std::uint64_t mostBytes)
{
    Corners corners(mostBytes);
    const std::uint32_t count = countOf(bytes);
    for (std::size_t i = 0; i < count; ++i) {
        const std::span<const std::byte> triangle = bytes.subspan(kHeader + i * kTriangle + 12, 36);
        for (std::size_t corner = 0; corner < 3; ++corner) {
            glm::dvec3 position(0);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                std::uint32_t word = 0;
                for (std::size_t k = 0; k < 4; ++k)
                    word |= static_cast<std::uint32_t>(triangle[12 * corner + 4 * axis + k])
                            << 8 * k;
                position[axis] = static_cast<double>(std::bit_cast<float>(word));
            }
            if (auto failed = corners.add(position))
                return tl::unexpected(*failed);
        }
    }
    return corners.take();
}

core::Result<voxels::TriangleModel>
readText(std::span<const std::byte> bytes, std::uint64_t mostBytes)
{
    TextScanner text(bytes);
    Corners corners(mostBytes);
    bool isStl = false;
    while (text.nextLine()) {
        const std::string_view key = text.word();
        isStl = isStl || key == "solid";
        if (key == "endfacet" && !corners.isWhole())
            return tl::unexpected(damaged(text.at("a facet doesn't have three vertices")));
        if (key != "vertex")
            continue;
        glm::dvec3 position(0);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto number = text.number<double>();
            if (!number)
                return tl::unexpected(damaged(text.at("a vertex needs three numbers")));
            position[axis] = *number;
        }
        if (auto failed = corners.add(position))
            return tl::unexpected(*failed);
    }
    if (!isStl)
        return tl::unexpected(damaged("it is neither a text nor a binary STL file"));
    if (!corners.isWhole())
        return tl::unexpected(damaged("it ends within a facet"));
    return corners.take();
}

} // namespace

core::Result<voxels::TriangleModel>
readStl(std::span<const std::byte> bytes, const ModelContext& context)
{
    // binary files may begin with 'solid', too: their length tells
    if (bytes.size() >= kHeader) {
        const std::uint64_t whole = kHeader + std::uint64_t{countOf(bytes)} * kTriangle;
        if (bytes.size() == whole)
            return readBinary(bytes, context.mostBytes);
        const bool isText = std::memcmp(bytes.data(), "solid", 5) == 0;
        if (!isText)
            return tl::unexpected(damaged(
                "it has " + std::to_string(bytes.size()) + " bytes, and its " +
                std::to_string(countOf(bytes)) + " triangles take " + std::to_string(whole)));
    }
    return readText(bytes, context.mostBytes);
}

} // namespace isofront::exchange
