#include "ViewerApi.h"

#include <isofront/core/Hash.h>

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

namespace isofront::server {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostBytes = std::uintmax_t{64} << 20U;
constexpr std::string_view kPage = "index.html";
constexpr std::string_view kAssets = "assets";

/// Nothing but what the service itself sends; compiled decoders may run, text as code may not.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; "
    "img-src 'self' data: blob:; connect-src 'self'; worker-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'";

constexpr const char* kNotBuilt = R"(<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>Isofront</title>
<h1>The service runs, its viewer isn't built</h1>
<p>Programs can use the service: <a href="openapi.json">openapi.json</a> describes it.</p>
<p>To see scenes in the browser, install Node.js 18 or newer and npm, build Isofront again
(<code>./run build</code>), and start the service anew. A viewer that is built already is found by
<code>isofront serve --viewer DIR</code>.</p>
</html>
)";

constexpr std::array<std::pair<std::string_view, const char*>, 9> kMediaTypes{{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".json", "application/json"},
    {".webmanifest", "application/manifest+json"},
    {".wasm", "application/wasm"},
    {".txt", "text/plain; charset=utf-8"},
}};

const char* mediaTypeOf(const fs::path& path)
{
    const std::string extension = path.extension().string();
    const auto* const known = std::ranges::find(
        kMediaTypes, std::string_view(extension), &std::pair<std::string_view, const char*>::first);
    return known != kMediaTypes.end() ? known->second : "application/octet-stream";
}

std::string tagOf(const std::string& bytes)
{
    std::uint64_t hash = bytes.size();
    for (std::size_t begin = 0; begin < bytes.size(); begin += sizeof(std::uint64_t)) {
        std::uint64_t word = 0;
        std::memcpy(
            &word, bytes.data() + begin, std::min(bytes.size() - begin, sizeof(std::uint64_t)));
        hash = core::hashCombined(hash, word);
    }
    std::array<char, 20> text{};
    std::snprintf(text.data(), text.size(), "\"%016llx\"", static_cast<unsigned long long>(hash));
    return text.data();
}

/// With gzip's header and trailer; empty if it can't be done.
std::string gzipped(const std::string& bytes)
{
    z_stream stream{};
    constexpr int kGzip = 16;
    if (deflateInit2(
            &stream,
            Z_BEST_COMPRESSION,
            Z_DEFLATED,
            MAX_WBITS + kGzip,
            MAX_MEM_LEVEL,
            Z_DEFAULT_STRATEGY) != Z_OK)
        return {};
    std::string packed(deflateBound(&stream, bytes.size()), '\0');
    // zlib doesn't write to what it reads, but for C's sake doesn't say so
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    const bool isWhole = deflate(&stream, Z_FINISH) == Z_STREAM_END;
    packed.resize(isWhole ? stream.total_out : 0);
    deflateEnd(&stream);
    return packed;
}

ViewerFiles::File fileOf(const fs::path& path, std::string bytes)
{
    ViewerFiles::File file;
    file.mediaType = mediaTypeOf(path);
    file.plainTag = tagOf(bytes);
    std::string packed = gzipped(bytes);
    if (!packed.empty() && packed.size() < bytes.size() / 10 * 9) {
        file.packedTag = tagOf(packed);
        file.packed = std::make_shared<const std::string>(std::move(packed));
    }
    file.plain = std::make_shared<const std::string>(std::move(bytes));
    return file;
}

/// Whether a list of codings has gzip, and doesn't refuse it by a weight of 0.
bool takesGzip(std::string_view accepted)
{
    constexpr std::string_view kGzip = "gzip";
    const std::size_t begin = accepted.find(kGzip);
    if (begin == std::string_view::npos)
        return false;
    accepted = accepted.substr(begin + kGzip.size());
    const std::string_view weight =
        accepted.substr(0, std::min(accepted.find(','), accepted.size()));
    const std::size_t equals = weight.find("q=");
    return equals == std::string_view::npos ||
           weight.find_first_of("123456789", equals) != std::string_view::npos;
}

Response pageHeaders()
{
    Response response;
    response.headers = {
        {"Content-Security-Policy", kPolicy},
        {"Referrer-Policy", "no-referrer"},
        {"Cross-Origin-Opener-Policy", "same-origin"}};
    return response;
}

/// @param isHashed  its name changes with what is in it
Response sent(const ViewerFiles::File& file, const Request& request, bool isHashed)
{
    Response response = pageHeaders();
    response.headers.emplace_back("Content-Type", file.mediaType);
    response.headers.emplace_back(
        "Cache-Control", isHashed ? "public, max-age=31536000, immutable" : "no-cache");
    const bool isPacked = file.packed && takesGzip(request.header("accept-encoding"));
    if (file.packed)
        response.headers.emplace_back("Vary", "Accept-Encoding");
    if (isPacked)
        response.headers.emplace_back("Content-Encoding", "gzip");
    response.headers.emplace_back("ETag", isPacked ? file.packedTag : file.plainTag);
    response.sharedBody = isPacked ? file.packed : file.plain;
    return response;
}

Response notBuilt()
{
    Response response = pageHeaders();
    response.headers.emplace_back("Content-Type", "text/html; charset=utf-8");
    response.headers.emplace_back("Cache-Control", "no-store");
    response.body = kNotBuilt;
    return response;
}

Route fileRoute(std::string pattern, std::string name)
{
    Route route;
    route.pattern = std::move(pattern);
    route.name = std::move(name);
    route.scope = Scope::none;
    route.isDescribed = false;
    return route;
}

} // namespace

core::Result<ViewerFiles> ViewerFiles::read(const fs::path& folder)
{
    ViewerFiles files;
    std::uintmax_t total = 0;
    const auto refused = [](const fs::path& path, const std::string& why) {
        return core::failure(
            core::ErrorCode::inputOutput,
            "viewer: " + path.string() + ": " + why + " (build it anew, or leave it out)");
    };
    for (const std::string_view below : {std::string_view(), kAssets}) {
        std::error_code error;
        for (fs::directory_iterator entry(folder / below, error), end; !error && entry != end;
             entry.increment(error)) {
            if (!entry->is_regular_file(error) || error)
                continue;
            total += entry->file_size(error);
            if (error || total > kMostBytes)
                return refused(entry->path(), "that is too much for a web client");
            std::ifstream in(entry->path(), std::ios::binary);
            std::ostringstream bytes;
            bytes << in.rdbuf();
            if (!in)
                return refused(entry->path(), "can't be read");
            const std::string name = (fs::path(below) / entry->path().filename()).generic_string();
            files._files.emplace(name, fileOf(entry->path(), std::move(bytes).str()));
        }
    }
    if (files.find(std::string(kPage)) == nullptr)
        return refused(folder, "there is no index.html");
    return files;
}

const ViewerFiles::File* ViewerFiles::find(const std::string& path) const
{
    const auto found = _files.find(path);
    return found != _files.end() ? &found->second : nullptr;
}

Api viewerApi(ViewerFiles files)
{
    Api api;
    const auto shared = std::make_shared<const ViewerFiles>(std::move(files));

    Route page = fileRoute("/", "viewer");
    page.handle = [shared](const Request& request) {
        const ViewerFiles::File* const file = shared->find(std::string(kPage));
        return file != nullptr ? sent(*file, request, false) : notBuilt();
    };
    api.routes.push_back(std::move(page));

    Route assets = fileRoute("/assets/{file}", "viewerAsset");
    assets.parameters = {{"file", "of the viewer", Parameter::Kind::text, true}};
    assets.handle = [shared](const Request& request) {
        const ViewerFiles::File* const file =
            shared->find(std::string(kAssets) + "/" + request.parameters.at("file"));
        return file != nullptr ? sent(*file, request, true)
                               : problem(404, "there is nothing at " + request.path);
    };
    api.routes.push_back(std::move(assets));

    for (const auto& [name, file] : shared->all()) {
        if (name.find('/') != std::string::npos)
            continue;
        Route beside = fileRoute("/" + name, "viewerFile");
        beside.handle = [shared, &file = file](const Request& request) {
            return sent(file, request, false);
        };
        api.routes.push_back(std::move(beside));
    }
    return api;
}

} // namespace isofront::server
