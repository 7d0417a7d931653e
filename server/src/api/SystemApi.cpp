#include "SystemApi.h"

#include "OpenApi.h"

namespace isofront::server {

using Json = nlohmann::ordered_json;

Api systemApi(Service& service)
{
    Api api;
    Route health;
    health.pattern = "/healthz";
    health.name = "health";
    health.summary = "Whether the service takes work.";
    health.scope = Scope::none;
    health.answers = {
        {200, "it does", "application/json", "Health"},
        {503, "it is ending", "application/json", "Health"}};
    health.handle = [&service](const Request&) {
        const bool isEnding = service.isDraining();
        return jsonResponse({{"status", isEnding ? "ending" : "ok"}}, isEnding ? 503 : 200)
            .with("Cache-Control", "no-store");
    };
    api.routes.push_back(std::move(health));

    Route metrics;
    metrics.pattern = "/metrics";
    metrics.name = "metrics";
    metrics.summary = "What the service counts, for Prometheus.";
    metrics.scope = Scope::admin;
    metrics.answers = {{200, "text exposition format 0.0.4", "text/plain"}};
    metrics.handle = [&service](const Request&) {
        Response response;
        response.headers = {
            {"Content-Type", "text/plain; version=0.0.4; charset=utf-8"},
            {"Cache-Control", "no-store"}};
        response.body = service.metrics().text();
        return response;
    };
    api.routes.push_back(std::move(metrics));

    Route description;
    description.pattern = "/openapi.json";
    description.name = "openapi";
    description.summary = "This description.";
    description.scope = Scope::none;
    description.answers = {{200, "an OpenAPI 3.1 document", "application/json"}};
    description.handle = [&service](const Request&) {
        return jsonResponse(openApiOf(service.routes(), ISOFRONT_VERSION));
    };
    api.routes.push_back(std::move(description));

    api.schemas["Health"] = Json{
        {"type", "object"},
        {"required", {"status"}},
        {"properties", {{"status", {{"type", "string"}, {"enum", {"ok", "ending"}}}}}}};
    return api;
}

} // namespace isofront::server
