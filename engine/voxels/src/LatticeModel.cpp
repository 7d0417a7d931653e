#include "LatticeModel.h"

#include "LinearColour.h"

#include <cmath>
#include <cstddef>
#include <string>

namespace isofront::voxels {

LatticeTriangle LatticeModel::triangle(std::uint32_t index) const
{
    LatticeTriangle corners;
    for (std::size_t corner = 0; corner < 3; ++corner)
        for (std::size_t axis = 0; axis < 3; ++axis)
            corners[corner][axis] = points[model.triangles[index][corner]][axis];
    return corners;
}

LatticeModel onLattice(const TriangleModel& model, const VoxelLattice& lattice)
{
    LatticeModel result{model, lattice, {}, {}, {}};
    const double scale = static_cast<double>(kSteps) / lattice.edge;
    result.points.reserve(model.positions.size());
    for (const glm::dvec3& position : model.positions) {
        std::array<std::int32_t, 3> point{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double place = std::round((position[axis] - lattice.origin[axis]) * scale);
            // what is not finite, or far away, belongs to no triangle that counts
            if (std::abs(place) < 1 << 30)
                point[axis] = static_cast<std::int32_t>(place);
        }
        result.points.push_back(point);
    }
    const std::array<float, 256> linear = linearOfCodes();
    result.colours.reserve(model.colours.size());
    for (const std::uint32_t colour : model.colours) {
        const float opacity = static_cast<float>(colour >> 24U) / 255.0F;
        result.colours.push_back(
            {opacity * linear[colour & 0xffU],
             opacity * linear[colour >> 8U & 0xffU],
             opacity * linear[colour >> 16U & 0xffU],
             opacity});
    }
    result.textures.reserve(model.textures.size());
    for (const Texture& texture : model.textures)
        result.textures.emplace_back(texture);
    return result;
}

std::optional<core::Error> checkColours(const TriangleModel& model)
{
    const auto damaged = [](const std::string& what) {
        return core::Error{core::ErrorCode::badData, "the model " + what};
    };
    if (!model.colours.empty() && model.colours.size() != model.positions.size())
        return damaged(
            "has " + std::to_string(model.colours.size()) + " colours for " +
            std::to_string(model.positions.size()) + " positions");
    if (model.textureOf.size() != model.textureCorners.size() ||
        (!model.textureOf.empty() && model.textureOf.size() != model.triangles.size()))
        return damaged(
            "has " + std::to_string(model.textureOf.size()) + " textures and " +
            std::to_string(model.textureCorners.size()) + " places in them for " +
            std::to_string(model.triangles.size()) + " triangles");
    for (const std::uint32_t texture : model.textureOf)
        if (texture != kNoTexture && texture >= model.textures.size())
            return damaged("names texture " + std::to_string(texture) + ", which is not there");
    for (const Texture& texture : model.textures) {
        const core::Image& image = texture.image;
        if (image.width < 1 || image.height < 1 ||
            image.rgba.size() !=
                4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height))
            return damaged("has a texture whose size is not that of its pixels");
    }
    return std::nullopt;
}

} // namespace isofront::voxels
