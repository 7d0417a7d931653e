#pragma once

#include <string_view>
#include <vector>

namespace isofront::fields {

struct PresetText {
    std::string_view name; ///< of the file, without .json
    std::string_view json;
};

/// A graph to start from; all others are terrains.
inline constexpr std::string_view kExamplePreset = "example";

/// The presets that come with the library, embedded when it was built.
const std::vector<PresetText>& presetTexts();

} // namespace isofront::fields
