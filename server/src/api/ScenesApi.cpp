#include "ScenesApi.h"

#include "../scenes/SceneFiles.h"

#include <isofront/core/Hash.h>
#include <isofront/fields/Procedural.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <string>
#include <utility>

namespace isofront::server {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLongestName = 200;
constexpr const char* kNameRule = "a name has up to 200 bytes, and no control characters";
constexpr std::size_t kLongestSource = 1000;
/// Of what describes a scene; objects are searched key by key.
constexpr std::size_t kLongestBody = std::size_t{16} << 10U;

/// A weak tag of what a client is told: it changes when that does.
Response tagged(const Json& json)
{
    Response response = jsonResponse(json);
    std::uint64_t hash = response.body.size();
    for (const char c : response.body)
        hash = core::hashCombined(hash, static_cast<unsigned char>(c));
    std::array<char, 24> tag{};
    std::snprintf(tag.data(), tag.size(), "\"%016llx\"", static_cast<unsigned long long>(hash));
    response.headers.emplace_back("ETag", tag.data());
    response.headers.emplace_back("Cache-Control", "no-cache");
    return response;
}

Response notThere(const std::string& id)
{
    return problem(404, "there is no scene '" + id + "'");
}

Response created(const SceneRecord& record)
{
    return jsonResponse(toJson(record, true), 201).with("Location", "/v1/scenes/" + record.id);
}

/// As `problem`, but for what a client can't mend by asking otherwise.
Response refusedScene(const core::Error& error)
{
    if (error.code == core::ErrorCode::resourceLimit)
        return problem(507, error.message);
    return problem(error);
}

Response createScene(SceneRegistry& scenes, const Request& request)
{
    if (!request.header("content-type").starts_with("application/json"))
        return problem(415, "send a JSON object as application/json");
    if (request.body.size() > kLongestBody)
        return problem(413, "a scene is described by up to 16 KiB");
    const Json json = Json::parse(request.body, nullptr, false);
    if (!json.is_object())
        return problem(400, "the body is no JSON object");
    SceneOrigin origin;
    std::string name;
    for (const auto& [key, value] : json.items()) {
        if (key == "options") {
            auto options = parseOptions(value);
            if (!options)
                return problem(options.error());
            origin.options = std::move(*options);
            continue;
        }
        if (key != "name" && key != "formula" && key != "file")
            return problem(
                400, "there is no '" + key + "': there are name, formula, file, options");
        if (!value.is_string())
            return problem(400, "'" + key + "' is to be a text");
        if (key == "name") {
            name = value.get<std::string>();
            continue;
        }
        if (!origin.text.empty())
            return problem(400, "give either a formula or a file");
        origin.kind = key == "file" ? SceneOrigin::Kind::file : SceneOrigin::Kind::procedural;
        origin.text = value.get<std::string>();
    }
    if (origin.text.empty())
        return problem(400, "give a 'formula', as proc:terrain?preset=canyon, or a 'file'");
    if (name.size() > kLongestName || !isPlainText(name))
        return problem(400, kNameRule);
    if (!isPlainText(origin.text))
        return problem(400, "a formula or a path has no control characters");
    if (origin.text.size() > kLongestSource)
        return problem(400, "a formula or a path has up to 1000 bytes");
    const auto record = scenes.create(name, origin);
    return record ? created(*record) : refusedScene(record.error());
}

/// The numbers of "1,2.5,.3" as a JSON array, or the text itself where it isn't that.
Json numbersOf(const std::string& text)
{
    Json numbers = Json::array();
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        double number = 0;
        const auto read = std::from_chars(text.data() + begin, text.data() + end, number);
        if (read.ec != std::errc{} || read.ptr != text.data() + end)
            return text;
        numbers.push_back(number);
        begin = end + 1;
    }
    return numbers;
}

/// What the query of an upload says.
tl::expected<SceneOrigin, Response> uploadIn(const Request& request)
{
    SceneOrigin origin;
    origin.kind = SceneOrigin::Kind::upload;
    auto name = uploadName(request.queried("file").value_or(""));
    if (!name)
        return tl::unexpected(problem(415, name.error().message));
    origin.text = std::move(*name);
    Json options = Json::object();
    for (const char* const key : {"grid", "series", "raw", "detail"})
        if (const auto value = request.queried(key))
            options[key] = *value;
    for (const char* const key : {"voxel_size", "pixel_size"})
        if (const auto value = request.queried(key))
            options[key] = numbersOf(*value);
    for (const char* const key : {"height_scale", "no_data", "mesh_resolution", "mesh_reach"})
        if (const auto value = request.queried(key))
            options[key] = numbersOf(*value).front();
    if (request.queried("name").value_or("").size() > kLongestName)
        return tl::unexpected(problem(400, kNameRule));
    auto parsed = parseOptions(options);
    if (!parsed)
        return tl::unexpected(problem(parsed.error()));
    origin.options = std::move(*parsed);
    return origin;
}

tl::expected<std::shared_ptr<BodyRoom>, Response>
expectUpload(SceneRegistry& scenes, const Request& request)
{
    const auto origin = uploadIn(request);
    if (!origin)
        return tl::unexpected(origin.error());
    auto room = scenes.expectUpload(*origin);
    if (!room)
        return tl::unexpected(refusedScene(room.error()));
    return std::move(*room);
}

Response createUpload(SceneRegistry& scenes, const Request& request)
{
    const auto origin = uploadIn(request);
    if (!origin)
        return origin.error();
    if (!request.file)
        return problem(400, "the body is to be the file");
    const auto record = scenes.create(
        request.queried("name").value_or(""), *origin, *request.file, request.room.get());
    return record ? created(*record) : refusedScene(record.error());
}

Json formulas()
{
    Json json;
    json["formulas"] = Json::array();
    for (const auto& source : fields::proceduralSources()) {
        Json formula{{"name", source.name}, {"description", source.description}};
        formula["parameters"] = Json::array();
        for (const auto& parameter : source.parameters) {
            Json one{
                {"name", parameter.name},
                {"description", parameter.description},
                {"default", parameter.defaultValue}};
            if (!parameter.choices.empty())
                one["choices"] = parameter.choices;
            else
                one["range"] = {parameter.least, parameter.most};
            formula["parameters"].push_back(std::move(one));
        }
        json["formulas"].push_back(std::move(formula));
    }
    return json;
}

Json typed(const char* type)
{
    return {{"type", type}};
}

Json listOf(Json item)
{
    return {{"type", "array"}, {"items", std::move(item)}};
}

Json objectOf(std::initializer_list<std::pair<const char*, Json>> properties)
{
    Json object = typed("object");
    for (const auto& [name, schema] : properties)
        object["properties"][name] = schema;
    return object;
}

void addSchemas(Api& api)
{
    const Json vector = listOf(typed("number"));
    const Json options = objectOf(
        {{"grid", typed("string")},
         {"series", typed("string")},
         {"raw", typed("string")},
         {"detail", typed("string")},
         {"voxel_size", vector},
         {"pixel_size", vector},
         {"height_scale", typed("number")},
         {"no_data", typed("number")},
         {"mesh_resolution", typed("integer")},
         {"mesh_reach", typed("number")}});
    Json scene = objectOf(
        {{"id", typed("string")},
         {"name", typed("string")},
         {"created", typed("string")},
         {"origin", {{"type", "string"}, {"enum", {"procedural", "file", "upload"}}}},
         {"source", typed("string")},
         {"state", {{"type", "string"}, {"enum", {"preparing", "ready", "failed"}}}},
         {"failure", typed("string")},
         {"kind", typed("string")},
         {"description",
          objectOf(
              {{"kind", typed("string")},
               {"text", typed("string")},
               {"bounds", listOf(vector)},
               {"isovalue", typed("number")},
               {"value_range", vector},
               {"histogram", listOf(typed("integer"))},
               {"view", objectOf({{"eye", vector}, {"target", vector}, {"up", vector}})},
               {"terrain", typed("boolean")},
               {"memory_bytes", typed("integer")},
               {"notes", listOf(typed("string"))}})},
         {"options", options},
         {"stored_bytes", typed("integer")}});
    scene["required"] = {"id", "name", "created", "origin", "source", "state"};
    api.schemas["Scene"] = std::move(scene);
    api.schemas["Scenes"] =
        objectOf({{"scenes", listOf({{"$ref", "#/components/schemas/Scene"}})}});
    api.schemas["NewScene"] = objectOf(
        {{"name", typed("string")},
         {"formula", typed("string")},
         {"file", typed("string")},
         {"options", options}});
    api.schemas["Files"] = objectOf(
        {{"files", listOf(objectOf({{"path", typed("string")}, {"bytes", typed("integer")}}))},
         {"complete", typed("boolean")}});
    api.schemas["Formulas"] = objectOf({{"formulas", listOf(typed("object"))}});
}

const Parameter kId{"id", "of the scene", Parameter::Kind::text, true};

} // namespace

Api scenesApi(SceneRegistry& scenes, const Settings& settings)
{
    Api api;
    addSchemas(api);

    Route list;
    list.pattern = "/v1/scenes";
    list.name = "listScenes";
    list.summary = "All scenes, oldest first.";
    list.answers = {{200, "the scenes", "application/json", "Scenes"}};
    list.handle = [&scenes](const Request&) {
        Json json;
        json["scenes"] = Json::array();
        for (const SceneRecord& record : scenes.list())
            json["scenes"].push_back(toJson(record, false));
        return tagged(json);
    };
    api.routes.push_back(std::move(list));

    Route create;
    create.method = Method::post;
    create.pattern = "/v1/scenes";
    create.name = "createScene";
    create.summary = "Makes a scene of a formula or of one of the service's files.";
    create.scope = Scope::write;
    create.body = BodyKind::text;
    create.bodyMediaType = "application/json";
    create.bodySchema = "NewScene";
    create.answers = {
        {201, "the scene; it is ready once its state says so", "application/json", "Scene"}};
    create.handle = [&scenes](const Request& request) { return createScene(scenes, request); };
    api.routes.push_back(std::move(create));

    Route upload;
    upload.method = Method::post;
    upload.pattern = "/v1/uploads";
    upload.name = "uploadScene";
    upload.summary = "Makes a scene of a volume, a mesh or an elevation raster that is the body.";
    upload.scope = Scope::write;
    upload.body = BodyKind::file;
    upload.bodyMediaType = "application/octet-stream";
    upload.parameters = {
        {"file", "name of the file; what it ends in says what it is", Parameter::Kind::text, true},
        {"name", "of the scene, for people"},
        {"grid", "which grid of a VDB file"},
        {"series", "which series"},
        {"raw", "what a raw file holds: SIZE,TYPE,ORDER[,OFFSET]"},
        {"detail", "added to an elevation raster: natural, rugged or none"},
        {"voxel_size", "of a volume: X,Y,Z"},
        {"pixel_size", "of an elevation raster: X,Y in metres"},
        {"height_scale", "of an elevation raster", Parameter::Kind::number},
        {"no_data", "of an elevation raster: the missing height", Parameter::Kind::number},
        {"mesh_resolution", "of a mesh: voxels along its longest edge", Parameter::Kind::integer},
        {"mesh_reach", "of a mesh: how far from it distances are known", Parameter::Kind::number}};
    upload.answers = {
        {201, "the scene; it is ready once its state says so", "application/json", "Scene"}};
    upload.expect = [&scenes](const Request& request) { return expectUpload(scenes, request); };
    upload.handle = [&scenes](const Request& request) { return createUpload(scenes, request); };
    api.routes.push_back(std::move(upload));

    Route describe;
    describe.pattern = "/v1/scenes/{id}";
    describe.name = "describeScene";
    describe.summary = "A scene: its bounds, its values and their histogram, where to look from.";
    describe.parameters = {kId};
    describe.answers = {{200, "the scene", "application/json", "Scene"}};
    describe.handle = [&scenes](const Request& request) {
        const std::string& id = request.parameters.at("id");
        const auto record = scenes.find(id);
        return record ? tagged(toJson(*record, true)) : notThere(id);
    };
    api.routes.push_back(std::move(describe));

    Route remove;
    remove.method = Method::remove;
    remove.pattern = "/v1/scenes/{id}";
    remove.name = "deleteScene";
    remove.summary = "Deletes a scene and what was uploaded for it.";
    remove.scope = Scope::write;
    remove.parameters = {kId};
    remove.answers = {{204, "it is gone"}};
    remove.handle = [&scenes](const Request& request) {
        const std::string& id = request.parameters.at("id");
        const auto removed = scenes.remove(id);
        if (!removed)
            return problem(removed.error());
        Response gone;
        gone.status = 204;
        return *removed ? gone : notThere(id);
    };
    api.routes.push_back(std::move(remove));

    Route files;
    files.pattern = "/v1/files";
    files.name = "listFiles";
    files.summary = "The service's files that scenes can be made of.";
    files.answers = {{200, "the files", "application/json", "Files"}};
    files.handle = [folder = std::make_shared<SourceFolder>(settings.sources)](const Request&) {
        const SourceFiles found = folder->files();
        Json json;
        json["files"] = Json::array();
        for (const SourceFile& file : found.files)
            json["files"].push_back({{"path", file.path}, {"bytes", file.bytes}});
        json["complete"] = found.isComplete;
        return tagged(json);
    };
    api.routes.push_back(std::move(files));

    Route formula;
    formula.pattern = "/v1/formulas";
    formula.name = "listFormulas";
    formula.summary = "The formulas that scenes can be made of, with their parameters.";
    formula.answers = {{200, "the formulas", "application/json", "Formulas"}};
    formula.handle = [](const Request&) { return tagged(formulas()); };
    api.routes.push_back(std::move(formula));
    return api;
}

} // namespace isofront::server
