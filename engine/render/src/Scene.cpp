#include "isofront/render/Scene.h"

namespace isofront::render {

TerrainLook terrainLook(std::string_view kind)
{
    TerrainLook look;
    if (kind == "canyon") {
        look.rock = {0.300F, 0.135F, 0.070F};
        look.otherRock = {0.420F, 0.240F, 0.130F};
        look.scree = {0.360F, 0.215F, 0.125F};
        look.grass = {0.085F, 0.082F, 0.036F};
        look.grassLine = 60.0F;
        look.snowLine = 6000.0F;
        look.layerThickness = 36.0F;
        look.haze = 0.7F;
    } else if (kind == "islands") {
        look.grass = {0.055F, 0.085F, 0.030F};
        look.grassLine = 3000.0F;
        look.snowLine = 9000.0F;
        look.haze = 0.6F;
    }
    return look;
}

} // namespace isofront::render
