#pragma once

#include "Tokens.h"

#include <isofront/core/Result.h>

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace isofront::server {

enum class Method { get, head, post, put, remove, options, other };

std::string_view nameOf(Method method);

/// A file that is deleted unless somebody takes it.
class UploadedFile {
public:
    explicit UploadedFile(std::filesystem::path path) : _path(std::move(path)) {}
    UploadedFile(const UploadedFile&) = delete;
    UploadedFile& operator=(const UploadedFile&) = delete;
    ~UploadedFile();

    [[nodiscard]] const std::filesystem::path& path() const { return _path; }
    /// Moves it to its place, on the same file system.
    core::Result<void> moveTo(const std::filesystem::path& place);

private:
    std::filesystem::path _path;
};

struct Response;

/// Room for a body that is coming in; it is given back when this goes.
class BodyRoom {
public:
    BodyRoom() = default;
    BodyRoom(const BodyRoom&) = delete;
    BodyRoom& operator=(const BodyRoom&) = delete;
    virtual ~BodyRoom() = default;

    /// Makes room for that many bytes of it.
    /// @return the answer, if there isn't so much
    virtual std::optional<Response> extend(std::uint64_t bytes) = 0;
    /// Leaves the room to whoever takes the body.
    /// @return its bytes
    virtual std::uint64_t take() = 0;
};

/// What somebody asks for, whole, with nothing of the transport.
struct Request {
    Method method = Method::get;
    std::string target;                            ///< as it was sent: path and query
    std::string path;                              ///< decoded
    std::map<std::string, std::string> parameters; ///< of the route's pattern: "id"
    std::multimap<std::string, std::string> query; ///< decoded
    std::map<std::string, std::string> headers;    ///< names in lower case
    std::string body;
    std::shared_ptr<BodyRoom> room;     ///< for the body, if it takes up any
    std::shared_ptr<UploadedFile> file; ///< the body of an upload
    std::string peer;                   ///< address, for the log
    Principal principal;
    /// Stopped when nobody waits for the answer any more, or it has taken too long.
    std::stop_token stop;

    /// Empty if it isn't there.
    [[nodiscard]] std::string_view header(const std::string& name) const;
    /// The first of that name.
    [[nodiscard]] std::optional<std::string> queried(const std::string& name) const;
};

struct Response {
    int status = 200;
    std::vector<std::pair<std::string, std::string>> headers = {};
    std::string body = {};
    std::shared_ptr<const std::string> sharedBody = {}; ///< in place of `body`, kept by others too

    [[nodiscard]] std::string_view content() const { return sharedBody ? *sharedBody : body; }
    Response&& with(std::string name, std::string value) &&;
};

/// The words that HTTP has for a status.
std::string_view reasonOf(int status);

Response jsonResponse(const nlohmann::ordered_json& json, int status = 200);
/// What went wrong, as `application/problem+json` with `status`, `title` and `detail`.
/// Source: M. Nottingham, E. Wilde, S. Dalal, "Problem Details for HTTP APIs", RFC 9457.
Response problem(int status, std::string_view detail);
/// The same for a failure of a lower floor.
Response problem(const core::Error& error);

/// Whether a text is UTF-8 without control characters, so that it can be told and written anywhere.
bool isPlainText(std::string_view text);

/// Decodes "%41" and leaves the rest; nothing for a % without two hexadecimal digits.
std::optional<std::string> percentDecoded(std::string_view text, bool plusIsSpace = false);

} // namespace isofront::server
