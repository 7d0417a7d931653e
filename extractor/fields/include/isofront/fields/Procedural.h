#pragma once

#include <isofront/core/Result.h>
#include <isofront/fields/Field.h>
#include <isofront/fields/GraphJson.h>

#include <glm/vec3.hpp>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace isofront::fields {

/// A field that is made rather than loaded, with all that is needed to look at it.
struct ProceduralSource {
    std::shared_ptr<const Field> field;
    core::Box domain;    ///< a cube [field]
    double isovalue = 0; ///< solid is where the value is at or above
    std::string description;
    glm::dvec3 eye{0};    ///< a good place to look from, outside the solid [field]
    glm::dvec3 target{0}; ///< what to look at from there [field]
    /// All of its parameters, given or not, in one way of writing: numbers in their shortest form,
    /// and of files the name without the folder.
    std::map<std::string, std::string> parameters = {};
};

/// One parameter of a source: a number within a range, one of some words, or a file.
struct ProceduralParameter {
    std::string name;
    std::string description;
    std::string defaultValue;
    double least = 0;
    double most = 0;
    bool whole = false;               ///< only whole numbers
    std::vector<std::string> choices; ///< if not empty, the value is one of these
    std::string fileSuffix;           ///< if not empty, the path of a file of this kind will do too
};

struct ProceduralDescription {
    std::string name;
    std::string description;
    std::vector<ProceduralParameter> parameters;
};

/// All there are, in the order in which they should be listed.
const std::vector<ProceduralDescription>& proceduralSources();

/// Makes a source by name. Parameters that are not given have their defaults; an unknown name,
/// parameter or value is a usage error that says which there are. For files see graph::readPreset.
/// @param load  loads the files that presets name
core::Result<ProceduralSource> makeProcedural(
    const std::string& name,
    const std::map<std::string, std::string>& parameters,
    const graph::FileLoader& load = {});

} // namespace isofront::fields
