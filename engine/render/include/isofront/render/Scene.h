#pragma once

#include <glm/vec3.hpp>

#include <optional>
#include <string_view>

namespace isofront::render {

/// Which light and materials the surface gets.
enum class Look {
    terrain, ///< a landscape: sun, sky, haze; rock, scree, grass and snow by slope and height
    studio,  ///< an object before a neutral wall under three lamps; both sides are shown
};

/// A landscape's materials. Colours are linear albedos, each component in [0, 1].
struct TerrainLook {
    double metre = 1.0;       ///< how long a metre is [world], > 0: sets the scale of all detail
    double baseHeight = 0.0;  ///< from where heights count, along `Scene::up` [world]
    float grassLine = 900.0F; ///< above it grass ends [m above the base]
    float snowLine = 1500.0F; ///< above it snow begins, where it is not too steep [m]
    float layerThickness = 28.0F; ///< of the rock's layers [m], > 0
    glm::vec3 rock{0.160F, 0.140F, 0.125F};
    glm::vec3 otherRock{0.245F, 0.200F, 0.165F}; ///< every other layer
    glm::vec3 grass{0.066F, 0.080F, 0.030F};
    glm::vec3 scree{0.215F, 0.195F, 0.170F};
    glm::vec3 snow{0.850F, 0.880F, 0.930F};
    /// Wavelength of the finest detail painted onto the ground [m]; each factor of 4 up to 256
    /// saves an octave of noise a pixel. Triangles are not concerned.
    float finestDetail = 0.06F;
    float haze = 1.0F; ///< how hazy the air is, >= 0; 0 is clear, 1 a fine day, 10 mist
};

/// A look made for a kind of terrain: "canyon" is red and nearly bare, "islands" green and clear.
/// Any other name, "alpine" among them, gives the default.
TerrainLook terrainLook(std::string_view kind);

/// An object's materials. Colours are linear albedos.
struct StudioLook {
    glm::vec3 surface{0.620F, 0.560F, 0.480F};
    glm::vec3 cap{0.500F, 0.300F, 0.200F}; ///< where the data ends and the surface is closed
};

/// How a picture is to look. Plain settings: any of them may change from frame to frame.
struct Scene {
    Look look = Look::terrain;
    TerrainLook terrain{};
    StudioLook studio{};
    glm::dvec3 up{0.0, 0.0, 1.0};              ///< away from the ground [world], not zero
    glm::dvec3 sunDirection{-0.6, 0.45, 0.42}; ///< towards the sun [world], not zero
    float exposure = 1.0F;                     ///< factor on all light, > 0
    /// A flat colour instead of sky or wall (linear, shown as it is), to cut the object out.
    std::optional<glm::vec3> backdrop{};
    /// Shows triangles from behind, too. Not given: in the studio only.
    std::optional<bool> twoSided{};
    /// Distance before which nothing is shown [world]; 0 means 2^-24 of the domain's edge. Depth is
    /// as precise with a small one.
    double nearPlane = 0.0;
    /// How far from the eye the sun casts shadows, in the terrain look [m]; 0 for none, which saves
    /// a second pass over the mesh. Shadows blur with the distance they have to cover.
    double shadowDistance = 3000.0;
    /// The shadow map is drawn anew every so many frames, >= 1, or sooner when the eye has flown a
    /// tenth of its width. More saves time; shadows then lag behind the mesh's changes. Those that
    /// fade (Renderer::beginTransition) don't: it is drawn anew when they begin to.
    int shadowInterval = 1;
    /// Weight of the present picture against the former one, in [0, 1]: TransitionClock::weight. So
    /// large a share of the pixels shows the present one. Without a number, all do.
    float transition = 1.0F;
    /// Softens stair steps; costs a pass over the picture. Not done where pixels have several
    /// samples (RendererOptions::samples).
    bool antialias = true;
};

} // namespace isofront::render
