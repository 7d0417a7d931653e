// Based on: Wavefront, "MTL material format", 1995.

#include "ObjMaterials.h"

#include "Picture.h"
#include "TextScanner.h"

#include <isofront/raster/FileBytes.h>

#include <algorithm>
#include <cmath>

namespace isofront::exchange {

void ObjMaterials::readLibrary(std::string_view name)
{
    if (_context.otherFiles == OtherFiles::ignore) {
        _model.notes.push_back("its materials are left out: other files aren't read");
        return;
    }
    const std::filesystem::path path = _context.folder / name;
    const auto bytes =
        raster::readFileBytes(path, _context.mostBytes, core::ErrorCode::resourceLimit);
    if (!bytes) {
        _model.notes.push_back(
            "its materials are left out: " + path.string() + ": " + bytes.error().message);
        return;
    }
    TextScanner text(*bytes);
    Material* material = nullptr;
    while (text.nextLine()) {
        const std::string_view key = text.word();
        if (key == "newmtl") {
            material = &_materials[std::string(text.rest())];
            *material = {};
        } else if (material != nullptr && key == "Kd") {
            std::uint32_t colour = 0xff000000U;
            for (unsigned i = 0; i < 3; ++i) {
                const double code = 255 * text.number<double>().value_or(1);
                colour |=
                    (code > 0 ? static_cast<std::uint32_t>(std::lround(std::min(code, 255.0))) : 0U)
                    << 8 * i;
            }
            material->colour = colour;
        } else if (material != nullptr && key == "map_Kd") {
            // options come before the name, which is last
            const std::string rest(text.rest());
            material->picture =
                rest.starts_with('-') ? rest.substr(rest.find_last_of(' ') + 1) : rest;
            std::ranges::replace(material->picture, '\\', '/');
        }
    }
}

std::uint32_t ObjMaterials::textureOf(std::string_view name)
{
    const auto found = _materials.find(name);
    if (found == _materials.end())
        return voxels::kNoTexture;
    Material& material = found->second;
    if (material.isUsed)
        return material.texture;
    material.isUsed = true;
    core::Image image{1, 1, {}};
    for (unsigned i = 0; i < 4; ++i)
        image.rgba.push_back(static_cast<std::uint8_t>(material.colour >> 8 * i & 0xffU));
    if (!material.picture.empty()) {
        auto picture = readPicture(_context.folder / material.picture, _context.mostBytes);
        if (picture)
            image = std::move(*picture);
        else
            _model.notes.push_back("a texture is left out: " + picture.error().message);
    }
    material.texture = static_cast<std::uint32_t>(_model.textures.size());
    _model.textures.push_back({std::move(image)});
    return material.texture;
}

} // namespace isofront::exchange
