#include "Route.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace isofront::server {
namespace {

bool isParameter(std::string_view segment)
{
    return segment.starts_with('{');
}

bool takesRest(std::string_view segment)
{
    return segment.ends_with("...}");
}

std::vector<std::string_view> split(std::string_view path)
{
    std::vector<std::string_view> segments;
    for (std::size_t begin = 1; begin <= path.size();) {
        const std::size_t end = std::min(path.find('/', begin), path.size());
        segments.push_back(path.substr(begin, end - begin));
        begin = end + 1;
    }
    return segments;
}

std::optional<std::map<std::string, std::string>>
matched(std::string_view pattern, const std::vector<std::string>& segments)
{
    const std::vector<std::string_view> wanted = split(pattern);
    std::map<std::string, std::string> parameters;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const std::string_view segment = wanted[i];
        if (takesRest(segment)) {
            std::string rest;
            for (std::size_t j = i; j < segments.size(); ++j)
                rest += (j == i ? "" : "/") + segments[j];
            parameters.emplace(segment.substr(1, segment.size() - 5), rest);
            return parameters;
        }
        if (i >= segments.size())
            return std::nullopt;
        if (isParameter(segment)) {
            if (segments[i].empty())
                return std::nullopt;
            parameters.emplace(segment.substr(1, segment.size() - 2), segments[i]);
        } else if (segment != segments[i]) {
            return std::nullopt;
        }
    }
    return segments.size() == wanted.size() ? std::optional(parameters) : std::nullopt;
}

bool isOfKind(const std::string& text, Parameter::Kind kind)
{
    const char* end = text.data() + text.size();
    switch (kind) {
    case Parameter::Kind::text:
        return true;
    case Parameter::Kind::boolean:
        return text == "true" || text == "false";
    case Parameter::Kind::integer: {
        long long number = 0;
        const auto read = std::from_chars(text.data(), end, number);
        return read.ec == std::errc{} && read.ptr == end;
    }
    case Parameter::Kind::number: {
        double number = 0;
        const auto read = std::from_chars(text.data(), end, number);
        return read.ec == std::errc{} && read.ptr == end && std::isfinite(number);
    }
    }
    return false;
}

std::string_view nameOf(Parameter::Kind kind)
{
    switch (kind) {
    case Parameter::Kind::text:
        return "a text";
    case Parameter::Kind::boolean:
        return "true or false";
    case Parameter::Kind::integer:
        return "a whole number";
    case Parameter::Kind::number:
        return "a finite number";
    }
    return "";
}

/// @param names  "GET, HEAD"
void addMethod(std::string& names, const Route& route)
{
    std::string name(server::nameOf(route.method));
    if (route.method == Method::get && !route.open)
        name += ", HEAD";
    if (names.find(name) == std::string::npos)
        names += (names.empty() ? "" : ", ") + name;
}

} // namespace

void RouteTable::add(Api api)
{
    for (Route& route : api.routes)
        _routes.push_back(std::move(route));
    _schemas.merge(api.schemas);
}

RouteTable::Match RouteTable::find(Method method, const std::vector<std::string>& segments) const
{
    Match none;
    for (const Route& route : _routes) {
        auto parameters = matched(route.pattern, segments);
        if (!parameters)
            continue;
        const bool isHead = method == Method::head && route.method == Method::get && !route.open;
        if (route.method == method || isHead)
            return {&route, std::move(*parameters), {}};
        addMethod(none.allowed, route);
    }
    return none;
}

std::string RouteTable::methods() const
{
    std::string names;
    for (const Route& route : _routes)
        addMethod(names, route);
    return names;
}

std::optional<std::vector<std::string>> segmentsOf(std::string_view path)
{
    if (!path.starts_with('/'))
        return std::nullopt;
    std::vector<std::string> segments;
    for (const std::string_view segment : split(path)) {
        auto decoded = percentDecoded(segment);
        if (!decoded || *decoded == "." || *decoded == "..")
            return std::nullopt;
        const bool isSafe = std::ranges::none_of(*decoded, [](char c) {
            return c == '/' || c == '\\' || (c >= 0 && c < 0x20) || c == 0x7f;
        });
        if (!isSafe)
            return std::nullopt;
        segments.push_back(std::move(*decoded));
    }
    return segments;
}

std::optional<std::string> faultInQuery(const Route& route, const Request& request)
{
    const auto known = [&](const std::string& name) {
        return std::ranges::find(route.parameters, name, &Parameter::name);
    };
    for (const auto& [name, value] : request.query) {
        const auto parameter = known(name);
        if (parameter == route.parameters.end() || request.parameters.contains(name)) {
            std::string names;
            for (const Parameter& one : route.parameters)
                if (!request.parameters.contains(one.name))
                    names += (names.empty() ? "" : ", ") + one.name;
            return "there is no parameter '" + name + "'" +
                   (names.empty() ? ": this takes none" : ": there are " + names);
        }
        if (!isPlainText(value))
            return "'" + name + "' is no UTF-8 text without control characters";
        if (request.query.count(name) > 1)
            return "'" + name + "' is given more than once";
        if (!isOfKind(value, parameter->kind))
            return "'" + name + "' is '" + value + "', not " + std::string(nameOf(parameter->kind));
    }
    for (const Parameter& parameter : route.parameters)
        if (parameter.isRequired && !request.parameters.contains(parameter.name) &&
            !request.query.contains(parameter.name))
            return "'" + parameter.name + "' is missing: " + parameter.description;
    return std::nullopt;
}

} // namespace isofront::server
