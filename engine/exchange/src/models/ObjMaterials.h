#pragma once

#include "ModelFormats.h"

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace isofront::exchange {

/// The materials of an OBJ file, as textures of a model: the picture of a material, or one pixel of
/// its colour.
class ObjMaterials {
public:
    ObjMaterials(const ModelContext& context, voxels::TriangleModel& model)
        : _context(context), _model(model)
    {
    }

    /// Reads a file that `mtllib` names. What is wrong with it becomes a note of the model.
    void readLibrary(std::string_view name);
    /// The texture of a material; kNoTexture for one that is not known.
    std::uint32_t textureOf(std::string_view material);

private:
    struct Material {
        std::uint32_t colour = 0xffffffffU; ///< 8-bit sRGB, red lowest
        std::string picture;
        std::uint32_t texture = voxels::kNoTexture; ///< once it is used
        bool isUsed = false;
    };
    const ModelContext& _context;
    voxels::TriangleModel& _model;
    std::map<std::string, Material, std::less<>> _materials;
};

} // namespace isofront::exchange
