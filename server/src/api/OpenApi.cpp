#include "OpenApi.h"

#include <string>

namespace isofront::server {
namespace {

using Json = nlohmann::ordered_json;

const char* typeOf(Parameter::Kind kind)
{
    switch (kind) {
    case Parameter::Kind::text:
        return "string";
    case Parameter::Kind::boolean:
        return "boolean";
    case Parameter::Kind::integer:
        return "integer";
    case Parameter::Kind::number:
        return "number";
    }
    return "string";
}

Json schemaNamed(const std::string& name)
{
    return {{"$ref", "#/components/schemas/" + name}};
}

Json contentOf(const std::string& mediaType, const std::string& schema)
{
    Json media = Json::object();
    if (!schema.empty())
        media["schema"] = schemaNamed(schema);
    return Json{{mediaType, media}};
}

Json operationOf(const Route& route)
{
    Json operation;
    operation["operationId"] = route.name;
    operation["summary"] = route.summary;
    for (const Parameter& parameter : route.parameters) {
        const bool isInPath = route.pattern.find('{' + parameter.name + '}') != std::string::npos;
        operation["parameters"].push_back(
            {{"name", parameter.name},
             {"in", isInPath ? "path" : "query"},
             {"required", isInPath || parameter.isRequired},
             {"description", parameter.description},
             {"schema", {{"type", typeOf(parameter.kind)}}}});
    }
    if (route.body != BodyKind::none)
        operation["requestBody"] = {
            {"required", true}, {"content", contentOf(route.bodyMediaType, route.bodySchema)}};
    for (const Answer& answer : route.answers) {
        Json& response = operation["responses"][std::to_string(answer.status)];
        response["description"] = answer.description;
        if (!answer.mediaType.empty())
            response["content"] = contentOf(answer.mediaType, answer.schema);
    }
    operation["responses"]["default"] = {
        {"description", "what went wrong"},
        {"content", contentOf("application/problem+json", "Problem")}};
    if (route.scope == Scope::none)
        operation["security"] = Json::array();
    else
        operation["x-isofront-scope"] = nameOf(route.scope);
    return operation;
}

} // namespace

Json openApiOf(const RouteTable& table, std::string_view version)
{
    Json document;
    document["openapi"] = "3.1.0";
    document["info"] = {
        {"title", "Isofront"},
        {"version", version},
        {"description",
         "Shows, streams and exports isosurfaces of scalar fields at the detail that a view "
         "needs."}};
    document["paths"] = Json::object();
    for (const Route& route : table.routes()) {
        if (!route.isDescribed)
            continue;
        std::string method;
        for (const char c : nameOf(route.method))
            method += static_cast<char>(c - 'A' + 'a');
        document["paths"][route.pattern][method] = operationOf(route);
    }
    Json& components = document["components"];
    for (const auto& [name, schema] : table.schemas())
        components["schemas"][name] = schema;
    components["schemas"]["Problem"] = {
        {"type", "object"},
        {"description", "RFC 9457"},
        {"required", {"status", "title", "detail"}},
        {"properties",
         {{"status", {{"type", "integer"}}},
          {"title", {{"type", "string"}}},
          {"detail", {{"type", "string"}}}}}};
    components["securitySchemes"]["token"] = {{"type", "http"}, {"scheme", "bearer"}};
    // a token, or none where the service allows that
    document["security"] = Json::array({Json{{"token", Json::array()}}, Json::object()});
    return document;
}

} // namespace isofront::server
