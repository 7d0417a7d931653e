// The web client's files, as the service serves them.

#include "HttpClient.h"
#include "TemporaryFolder.h"
#include "api/ViewerApi.h"

#include <isofront/server/Server.h>

#include <gtest/gtest.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace isofront::server {
namespace {

namespace fs = std::filesystem;

class Viewer : public testing::Test {
protected:
    Viewer()
    {
        settings.port = 0;
        settings.data = folder.path / "data";
        settings.logLevel = "error";
        settings.anonymous = {"read"};
        settings.workers = 2;
        fs::create_directories(page / "assets" / "deeper");
        write(page / "index.html", "<!doctype html><title>page</title>");
        write(page / "icon.svg", "<svg/>");
        write(page / "assets" / "index-abc.js", script);
        write(page / "assets" / "deeper" / "hidden.txt", "treasure");
        write(folder.path / "secret.txt", "treasure");
    }

    static void write(const fs::path& path, const std::string& text)
    {
        std::ofstream(path, std::ios::binary) << text;
    }

    void start()
    {
        auto started = Server::start(settings);
        ASSERT_TRUE(started) << started.error().message;
        server = std::move(*started);
    }

    HttpAnswer
    get(const std::string& target,
        const std::string& headers = "",
        const std::string& method = "GET") const
    {
        return HttpClient(server->port()).ask(method, target, headers);
    }

    const std::string script = std::string(5000, 'x') + "();";
    TemporaryFolder folder;
    fs::path page = folder.path / "viewer";
    Settings settings;
    std::unique_ptr<Server> server;
};

std::string unpacked(const std::string& bytes)
{
    std::string text(1U << 16U, '\0');
    z_stream stream{};
    EXPECT_EQ(inflateInit2(&stream, MAX_WBITS + 16), Z_OK);
    std::string in = bytes;
    stream.next_in = reinterpret_cast<Bytef*>(in.data());
    stream.avail_in = static_cast<uInt>(in.size());
    stream.next_out = reinterpret_cast<Bytef*>(text.data());
    stream.avail_out = static_cast<uInt>(text.size());
    EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
    text.resize(stream.total_out);
    inflateEnd(&stream);
    return text;
}

TEST_F(Viewer, saysHowItIsBuiltWhereItIsNot)
{
    start();
    const HttpAnswer answer = get("/");
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.headers.at("content-type"), "text/html; charset=utf-8");
    EXPECT_NE(answer.body.find("./run build"), std::string::npos);
    EXPECT_EQ(get("/assets/index-abc.js").status, 404);
}

TEST_F(Viewer, servesThePageWithAStrictPolicy)
{
    settings.viewer = page;
    settings.anonymous = {};
    settings.tokens = folder.path / "tokens";
    write(settings.tokens, "read anna 2c7e0d1f6b9a4835\n");
    fs::permissions(settings.tokens, fs::perms::owner_read | fs::perms::owner_write);
    start();
    const HttpAnswer answer = get("/");
    EXPECT_EQ(answer.status, 200) << "the page asks for the token itself";
    EXPECT_EQ(answer.body, "<!doctype html><title>page</title>");
    EXPECT_EQ(answer.headers.at("content-type"), "text/html; charset=utf-8");
    EXPECT_EQ(answer.headers.at("cache-control"), "no-cache");
    EXPECT_EQ(answer.headers.at("x-content-type-options"), "nosniff");
    const std::string& policy = answer.headers.at("content-security-policy");
    EXPECT_EQ(policy.find("unsafe-inline"), std::string::npos);
    EXPECT_EQ(policy.find("http"), std::string::npos) << "nothing comes from elsewhere";
    EXPECT_NE(policy.find("default-src 'none'"), std::string::npos);
    EXPECT_EQ(get("/icon.svg").headers.at("content-type"), "image/svg+xml");

    const std::string tag = answer.headers.at("etag");
    const HttpAnswer same = get("/", "If-None-Match: " + tag + "\r\n");
    EXPECT_EQ(same.status, 304);
    EXPECT_TRUE(same.body.empty());
    EXPECT_EQ(get("/", "", "HEAD").headers.at("content-length"), "34");
    EXPECT_EQ(get("/v1/scenes").status, 401);
    EXPECT_EQ(get("/index.html", "", "POST").status, 405);
}

TEST_F(Viewer, sendsAssetsPackedAndForEver)
{
    settings.viewer = page;
    start();
    const std::string path = "/assets/index-abc.js";
    const HttpAnswer plain = get(path);
    EXPECT_EQ(plain.body, script);
    EXPECT_EQ(plain.headers.at("content-type"), "text/javascript; charset=utf-8");
    EXPECT_EQ(plain.headers.at("cache-control"), "public, max-age=31536000, immutable");
    EXPECT_EQ(plain.headers.at("vary"), "Accept-Encoding");
    EXPECT_FALSE(plain.headers.contains("content-encoding"));
    for (const char* const accepted : {"gzip", "br, gzip;q=0.5", "deflate,gzip, br"}) {
        const HttpAnswer packed = get(path, std::string("Accept-Encoding: ") + accepted + "\r\n");
        EXPECT_EQ(packed.headers.at("content-encoding"), "gzip") << accepted;
        EXPECT_LT(packed.body.size(), 100U);
        EXPECT_EQ(unpacked(packed.body), script);
        EXPECT_NE(packed.headers.at("etag"), plain.headers.at("etag"));
    }
    for (const char* const accepted : {"br", "gzip;q=0", "gzip; q=0.0, br"})
        EXPECT_EQ(get(path, std::string("Accept-Encoding: ") + accepted + "\r\n").body, script)
            << accepted;
}

TEST_F(Viewer, hasNoFilesButItsOwn)
{
    settings.viewer = page;
    start();
    for (const char* const path :
         {"/../secret.txt",
          "/assets/../../secret.txt",
          "/assets/..%2f..%2fsecret.txt",
          "/assets/%2e%2e/index.html",
          "/assets//etc/passwd",
          "/assets/%2fetc%2fpasswd",
          "/assets/..%5c..%5csecret.txt",
          "/assets/deeper/hidden.txt",
          "/assets/deeper",
          "/assets/",
          "/assets",
          "/secret.txt",
          "//secret.txt",
          "/assets/index-abc.js%00.txt"}) {
        const HttpAnswer answer = get(path);
        EXPECT_TRUE(answer.status == 404 || answer.status == 400) << path << " " << answer.status;
        EXPECT_EQ(answer.body.find("treasure"), std::string::npos) << path;
    }
}

TEST_F(Viewer, keepsWhatItReadWhenFilesChange)
{
    settings.viewer = page;
    start();
    fs::remove_all(page);
    EXPECT_EQ(get("/assets/index-abc.js").body, script);
}

TEST_F(Viewer, isRefusedWithoutAPage)
{
    fs::remove(page / "index.html");
    const auto files = ViewerFiles::read(page);
    ASSERT_FALSE(files);
    EXPECT_EQ(files.error().code, core::ErrorCode::inputOutput);
    EXPECT_NE(files.error().message.find("index.html"), std::string::npos);
    settings.viewer = page;
    EXPECT_FALSE(Server::start(settings));
}

} // namespace
} // namespace isofront::server
