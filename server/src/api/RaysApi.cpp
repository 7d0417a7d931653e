#include "RaysApi.h"

#include "../queries/Rays.h"
#include "ReadyScene.h"

#include <glm/geometric.hpp>

#include <cmath>
#include <string>
#include <utility>

namespace isofront::server {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostRays = 10'000;
/// Coordinates are below [world].
constexpr double kFarthest = 1e15;

struct Asked {
    std::vector<std::vector<double>> rows;
    std::optional<double> isovalue;
};

tl::unexpected<Response> refused(int status, const std::string& detail)
{
    return tl::unexpected(problem(status, detail));
}

/// Reads `{"NAME": [[numbers], ...], "isovalue": number}`.
/// @param length  of each of the rows
tl::expected<Asked, Response>
askedIn(const Request& request, const std::string& name, std::size_t length)
{
    if (!request.header("content-type").starts_with("application/json"))
        return refused(415, "send a JSON object as application/json");
    // an object that is sorted by its keys, which may be many
    const nlohmann::json json = nlohmann::json::parse(request.body, nullptr, false);
    if (!json.is_object())
        return refused(400, "the body is no JSON object");
    Asked asked;
    for (const auto& [key, value] : json.items())
        if (key != name && key != "isovalue")
            return refused(400, "there is no '" + key + "': there are " + name + ", isovalue");
    if (const auto isovalue = json.find("isovalue"); isovalue != json.end()) {
        if (!isovalue->is_number())
            return refused(400, "'isovalue' is to be a number");
        asked.isovalue = isovalue->get<double>();
    }
    const auto rows = json.find(name);
    const std::string wanted = "'" + name + "' is to be a list of lists of " +
                               std::to_string(length) + " numbers below 1e15";
    if (rows == json.end() || !rows->is_array())
        return refused(400, wanted);
    if (rows->size() > kMostRays)
        return refused(413, "ask for up to " + std::to_string(kMostRays) + " at once");
    for (const nlohmann::json& row : *rows) {
        if (!row.is_array() || row.size() != length)
            return refused(400, wanted);
        std::vector<double> numbers;
        for (const nlohmann::json& number : row) {
            if (!number.is_number() || !(std::abs(number.get<double>()) < kFarthest))
                return refused(400, wanted);
            numbers.push_back(number.get<double>());
        }
        asked.rows.push_back(std::move(numbers));
    }
    return asked;
}

Json toJson(const glm::dvec3& vector)
{
    return {vector.x, vector.y, vector.z};
}

Response castRays(SceneRegistry& scenes, core::Jobs& jobs, const Request& request)
{
    const auto asked = askedIn(request, "rays", 6);
    if (!asked)
        return asked.error();
    std::vector<WorldRay> rays;
    for (const std::vector<double>& row : asked->rows) {
        rays.push_back({{row[0], row[1], row[2]}, {row[3], row[4], row[5]}});
        if (rays.back().direction == glm::dvec3(0.0))
            return problem(400, "a ray's direction, its last three numbers, isn't 0,0,0");
    }
    const auto scene = readyScene(scenes, request.parameters.at("id"));
    if (!scene)
        return scene.error();
    const sources::Source& source = (*scene)->source;
    const double isovalue = asked->isovalue.value_or(source.defaultIsovalue);
    const auto hits = server::castRays(source, isovalue, rays, jobs, request.stop);
    if (!hits)
        return problem(hits.error());
    Json json{{"isovalue", isovalue}};
    json["hits"] = Json::array();
    for (const auto& hit : *hits) {
        Json one;
        if (hit)
            one = {
                {"point", toJson(hit->point)},
                {"distance", hit->distance},
                {"normal", hit->normal ? toJson(*hit->normal) : Json()}};
        json["hits"].push_back(std::move(one));
    }
    return jsonResponse(json);
}

Response findHeights(SceneRegistry& scenes, core::Jobs& jobs, const Request& request)
{
    const auto asked = askedIn(request, "points", 3);
    if (!asked)
        return asked.error();
    const auto scene = readyScene(scenes, request.parameters.at("id"));
    if (!scene)
        return scene.error();
    const sources::Source& source = (*scene)->source;
    std::vector<WorldRay> rays;
    for (const std::vector<double>& row : asked->rows)
        rays.push_back(rayFromAbove(source, {row[0], row[1], row[2]}));
    const double isovalue = asked->isovalue.value_or(source.defaultIsovalue);
    const auto hits = server::castRays(source, isovalue, rays, jobs, request.stop);
    if (!hits)
        return problem(hits.error());
    const glm::dvec3 up = glm::normalize(source.up);
    Json json{{"isovalue", isovalue}};
    json["up"] = toJson(up);
    json["heights"] = Json::array();
    for (const auto& hit : *hits)
        json["heights"].push_back(hit ? Json(glm::dot(hit->point, up)) : Json());
    return jsonResponse(json);
}

Json listOf(Json item)
{
    return {{"type", "array"}, {"items", std::move(item)}};
}

Json schemaOf(Json properties, std::vector<std::string> required)
{
    return {
        {"type", "object"},
        {"required", std::move(required)},
        {"properties", std::move(properties)}};
}

void addSchemas(Api& api)
{
    const Json number{{"type", "number"}};
    const Json vector = listOf(number);
    const auto optional = [](const char* type) { return Json{{"type", {type, "null"}}}; };
    Json hit = optional("object");
    hit["properties"] = {
        {"point", vector},
        {"distance", number},
        {"normal", {{"type", {"array", "null"}}, {"items", number}}}};
    api.schemas["Rays"] = schemaOf({{"rays", listOf(vector)}, {"isovalue", number}}, {"rays"});
    api.schemas["Rays"]["examples"] =
        Json::array({{{"rays", {{0, 0, 10, 0, 0, -1}, {0, 10, 0, 0, -1, 0}}}, {"isovalue", 0}}});
    api.schemas["Hits"] =
        schemaOf({{"isovalue", number}, {"hits", listOf(hit)}}, {"isovalue", "hits"});
    api.schemas["Points"] =
        schemaOf({{"points", listOf(vector)}, {"isovalue", number}}, {"points"});
    api.schemas["Points"]["examples"] =
        Json::array({{{"points", {{0, 0, 0}, {1, 2, 0}}}, {"isovalue", 0}}});
    api.schemas["Heights"] = schemaOf(
        {{"isovalue", number}, {"up", vector}, {"heights", listOf(optional("number"))}},
        {"isovalue", "up", "heights"});
}

} // namespace

Api raysApi(SceneRegistry& scenes, core::Jobs& jobs)
{
    Api api;
    addSchemas(api);

    Route rays;
    rays.method = Method::post;
    rays.pattern = "/v1/scenes/{id}/rays";
    rays.name = "castRays";
    rays.summary = "Where rays, each an origin and a direction in world units, first meet the "
                   "surface: a point, its distance, and the normal there.";
    rays.body = BodyKind::text;
    rays.bodyMediaType = "application/json";
    rays.bodySchema = "Rays";
    rays.parameters = {{"id", "of the scene", Parameter::Kind::text, true}};
    rays.answers = {
        {200, "a hit for each ray, null for those without one", "application/json", "Hits"}};
    rays.handle = [&scenes, &jobs](const Request& request) {
        return castRays(scenes, jobs, request);
    };

    Route heights = rays;
    heights.pattern = "/v1/scenes/{id}/heights";
    heights.name = "findHeights";
    heights.summary = "How high the surface is at points, along the scene's up, seen from above.";
    heights.bodySchema = "Points";
    heights.answers = {
        {200, "a height for each point, null where there is none", "application/json", "Heights"}};
    heights.handle = [&scenes, &jobs](const Request& request) {
        return findHeights(scenes, jobs, request);
    };
    api.routes.push_back(std::move(rays));
    api.routes.push_back(std::move(heights));
    return api;
}

} // namespace isofront::server
