#include "Message.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>

namespace isofront::server {

std::string_view nameOf(Method method)
{
    switch (method) {
    case Method::get:
        return "GET";
    case Method::head:
        return "HEAD";
    case Method::post:
        return "POST";
    case Method::put:
        return "PUT";
    case Method::remove:
        return "DELETE";
    case Method::options:
        return "OPTIONS";
    case Method::other:
        break;
    }
    return "other";
}

UploadedFile::~UploadedFile()
{
    std::error_code ignored;
    if (!_path.empty())
        std::filesystem::remove(_path, ignored);
}

core::Result<void> UploadedFile::moveTo(const std::filesystem::path& place)
{
    std::error_code error;
    std::filesystem::rename(_path, place, error);
    if (error)
        return core::failure(
            core::ErrorCode::inputOutput,
            "the upload can't be moved to " + place.string() + ": " + error.message());
    _path.clear();
    return {};
}

std::string_view Request::header(const std::string& name) const
{
    const auto found = headers.find(name);
    return found == headers.end() ? std::string_view() : std::string_view(found->second);
}

std::optional<std::string> Request::queried(const std::string& name) const
{
    const auto found = query.find(name);
    return found == query.end() ? std::nullopt : std::optional(found->second);
}

Response&& Response::with(std::string name, std::string value) &&
{
    headers.emplace_back(std::move(name), std::move(value));
    return std::move(*this);
}

std::string_view reasonOf(int status)
{
    static const std::map<int, std::string_view> reasons{
        {200, "OK"},
        {201, "Created"},
        {202, "Accepted"},
        {204, "No Content"},
        {304, "Not Modified"},
        {400, "Bad Request"},
        {401, "Unauthorized"},
        {403, "Forbidden"},
        {404, "Not Found"},
        {405, "Method Not Allowed"},
        {408, "Request Timeout"},
        {409, "Conflict"},
        {411, "Length Required"},
        {413, "Content Too Large"},
        {415, "Unsupported Media Type"},
        {421, "Misdirected Request"},
        {422, "Unprocessable Content"},
        {426, "Upgrade Required"},
        {429, "Too Many Requests"},
        {431, "Request Header Fields Too Large"},
        {500, "Internal Server Error"},
        {501, "Not Implemented"},
        {503, "Service Unavailable"},
        {507, "Insufficient Storage"}};
    const auto found = reasons.find(status);
    return found == reasons.end() ? "Unknown" : found->second;
}

Response jsonResponse(const nlohmann::ordered_json& json, int status)
{
    Response response;
    response.status = status;
    response.headers.emplace_back("Content-Type", "application/json");
    // names and messages may have any bytes; what isn't UTF-8 is replaced, never thrown about
    response.body = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    response.body += '\n';
    return response;
}

Response problem(int status, std::string_view detail)
{
    nlohmann::ordered_json json;
    json["status"] = status;
    json["title"] = reasonOf(status);
    json["detail"] = detail;
    Response response = jsonResponse(json, status);
    response.headers.front().second = "application/problem+json";
    response.headers.emplace_back("Cache-Control", "no-store");
    return response;
}

Response problem(const core::Error& error)
{
    switch (error.code) {
    case core::ErrorCode::usage:
        return problem(400, error.message);
    case core::ErrorCode::badData:
        return problem(422, error.message);
    case core::ErrorCode::inputOutput:
        return problem(500, error.message);
    case core::ErrorCode::noDevice:
        return problem(501, error.message);
    case core::ErrorCode::resourceLimit:
        return problem(503, error.message).with("Retry-After", "5");
    case core::ErrorCode::interrupted:
        return problem(503, error.message).with("Retry-After", "1");
    }
    return problem(500, error.message);
}

// Source: F. Yergeau, "UTF-8, a transformation format of ISO 10646", RFC 3629, section 4.
bool isPlainText(std::string_view text)
{
    for (std::size_t i = 0; i < text.size();) {
        const auto byteAt = [&](std::size_t at) {
            return at < text.size() ? static_cast<unsigned char>(text[at]) : 0U;
        };
        const unsigned first = byteAt(i++);
        if (first < 0x20 || first == 0x7f)
            return false;
        if (first < 0x80)
            continue;
        if (first < 0xc2 || first > 0xf4)
            return false;
        // shorter forms, surrogates and what lies past the last character are none
        const unsigned least = first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;
        const unsigned most = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
        if (byteAt(i) < least || byteAt(i) > most || (first == 0xc2 && byteAt(i) < 0xa0))
            return false;
        ++i;
        for (const unsigned longer : {0xe0U, 0xf0U})
            if (first >= longer && (byteAt(i++) & 0xc0U) != 0x80)
                return false;
    }
    return true;
}

std::optional<std::string> percentDecoded(std::string_view text, bool plusIsSpace)
{
    const auto digit = [](char c) {
        if (c >= '0' && c <= '9')
            return c - '0';
        if (c >= 'a' && c <= 'f')
            return c - 'a' + 10;
        if (c >= 'A' && c <= 'F')
            return c - 'A' + 10;
        return -1;
    };
    std::string decoded;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%') {
            if (i + 2 >= text.size() || digit(text[i + 1]) < 0 || digit(text[i + 2]) < 0)
                return std::nullopt;
            decoded += static_cast<char>(digit(text[i + 1]) * 16 + digit(text[i + 2]));
            i += 2;
        } else {
            decoded += plusIsSpace && text[i] == '+' ? ' ' : text[i];
        }
    }
    return decoded;
}

} // namespace isofront::server
