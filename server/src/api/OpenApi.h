#pragma once

#include "Route.h"

#include <nlohmann/json.hpp>

#include <string_view>

namespace isofront::server {

/// The description of all operations, for people and for programs that make clients. It is made of
/// the very table that requests are matched against, so it can't say what isn't there.
/// Source: OpenAPI Specification 3.1.0.
nlohmann::ordered_json openApiOf(const RouteTable& table, std::string_view version);

} // namespace isofront::server
