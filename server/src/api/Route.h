#pragma once

#include "../stream/Stream.h"
#include "Message.h"
#include "Scope.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace isofront::server {

/// One thing that a path or a query says.
struct Parameter {
    enum class Kind { text, number, integer, boolean };

    std::string name;
    std::string description;
    Kind kind = Kind::text;
    bool isRequired = false; ///< those of the path always are
};

/// One way in which an operation ends.
struct Answer {
    int status = 200;
    std::string description;
    std::string mediaType = {}; ///< empty: no body
    std::string schema = {};    ///< name of one of the API's schemas; empty: none
};

enum class BodyKind {
    none, ///< no body is taken
    text, ///< up to Settings::bodyBytes, in memory
    file, ///< up to Settings::uploadBytes, in a file
};

/// An operation of the service: how it is called, who may, what it does, and all that the
/// description for clients says of it.
struct Route {
    Method method = Method::get; ///< what takes GET takes HEAD too
    /// Segments, of which those in braces are parameters: "/v1/scenes/{id}". A last "{name...}"
    /// takes all that follow.
    std::string pattern;
    std::string name; ///< of the operation, in camel case, for clients that are generated
    std::string summary;
    Scope scope = Scope::read;
    BodyKind body = BodyKind::none;
    std::string bodyMediaType = {};
    std::string bodySchema = {};
    std::vector<Parameter> parameters = {};
    std::vector<Answer> answers = {};
    std::function<Response(const Request&)> handle = {};
    /// Asked before the body is read; may be null. Nothing, and why, if it isn't wanted.
    std::function<tl::expected<std::shared_ptr<BodyRoom>, Response>(const Request&)> expect = {};
    /// In place of `handle`: a WebSocket. Nothing, and why, if it can't be.
    std::function<tl::expected<std::unique_ptr<Stream>, Response>(const Request&)> open = {};
    bool isDescribed = true; ///< part of the description for clients
};

/// Operations that belong together, and the JSON schemas that they name.
struct Api {
    std::vector<Route> routes;
    std::map<std::string, nlohmann::ordered_json> schemas = {};
};

/// Finds the operation that a request asks for.
///
/// Thread: immutable once all is added.
class RouteTable {
public:
    void add(Api api);

    struct Match {
        const Route* route = nullptr;
        std::map<std::string, std::string> parameters = {};
        /// Without a route: the methods that the path has, as "GET, HEAD"; empty if there is no
        /// such path.
        std::string allowed = {};
    };
    /// @param segments  of the path, decoded
    [[nodiscard]] Match find(Method method, const std::vector<std::string>& segments) const;

    /// Those that anything takes, as "GET, HEAD".
    [[nodiscard]] std::string methods() const;
    [[nodiscard]] const std::vector<Route>& routes() const { return _routes; }
    [[nodiscard]] const std::map<std::string, nlohmann::ordered_json>& schemas() const
    {
        return _schemas;
    }

private:
    std::vector<Route> _routes;
    std::map<std::string, nlohmann::ordered_json> _schemas;
};

/// The segments of a path, decoded: {"v1", "scenes"} of "/v1/scenes". Nothing for paths that don't
/// begin with a slash, are badly encoded, or have a segment that is "." or "..", or contains a
/// slash, a backslash or a control character once decoded.
std::optional<std::vector<std::string>> segmentsOf(std::string_view path);

/// The first fault in what a request says in its query: an unknown or a missing name, a value of
/// another kind. Nothing if there is none.
std::optional<std::string> faultInQuery(const Route& route, const Request& request);

} // namespace isofront::server
