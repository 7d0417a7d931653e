#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/TriangleModel.h>

#include <cstdint>
#include <optional>
#include <string>

namespace isofront::exchange {

/// What is about to be added to a model.
struct ModelGrowth {
    std::uint64_t positions = 0;
    std::uint64_t triangles = 0;
    std::uint64_t otherBytes = 0; ///< that a reader keeps beside the model
};

/// What a model may take of memory: a few bytes of a file can stand for many of a model. Pictures
/// have limits of their own.
class ModelBudget {
public:
    explicit ModelBudget(std::uint64_t mostBytes) : _mostBytes(mostBytes) {}

    /// Why a model may not be as large as it is, with what is to be added, if so. It takes no time,
    /// so that readers can ask after every triangle.
    [[nodiscard]] std::optional<core::Error>
    check(const voxels::TriangleModel& model, const ModelGrowth& more = {}) const
    {
        const std::uint64_t bytes = bytesOf(model) + more.positions * kPositionBytes +
                                    more.triangles * kTriangleBytes + more.otherBytes;
        const std::uint64_t positions = model.positions.size() + more.positions;
        if (bytes <= _mostBytes && positions < kMostPositions)
            return std::nullopt;
        return overrun(positions, model.triangles.size() + more.triangles, bytes);
    }

private:
    /// With a colour, and with a place in a texture for each corner.
    static constexpr std::uint64_t kPositionBytes = sizeof(glm::dvec3) + 4;
    static constexpr std::uint64_t kTriangleBytes =
        sizeof(std::array<std::uint32_t, 3>) + 4 + sizeof(std::array<glm::vec2, 3>);
    /// Indices have 32 bits, and the last says that there is none.
    static constexpr std::uint64_t kMostPositions = 0xffffffffU;

    static std::uint64_t bytesOf(const voxels::TriangleModel& model)
    {
        return model.positions.size() * sizeof(glm::dvec3) + model.colours.size() * 4 +
               model.triangles.size() * sizeof(std::array<std::uint32_t, 3>) +
               model.textureOf.size() * 4 +
               model.textureCorners.size() * sizeof(std::array<glm::vec2, 3>);
    }
    [[nodiscard]] core::Error
    overrun(std::uint64_t positions, std::uint64_t triangles, std::uint64_t bytes) const
    {
        const std::string what = "its " + std::to_string(positions) + " positions and " +
                                 std::to_string(triangles) + " triangles, or more, ";
        if (positions >= kMostPositions)
            return {
                core::ErrorCode::resourceLimit,
                what + "are too many for indices of 32 bits; divide the model"};
        return {
            core::ErrorCode::resourceLimit,
            what + "take " + std::to_string(bytes) + " bytes, more than the memory limit of " +
                std::to_string(_mostBytes) + " bytes; raise it (--memory-limit)"};
    }

    std::uint64_t _mostBytes;
};

} // namespace isofront::exchange
