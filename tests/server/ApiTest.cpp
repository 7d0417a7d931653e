#include "TemporaryFolder.h"
#include "api/Guard.h"
#include "api/Message.h"
#include "api/Route.h"
#include "api/Tokens.h"

#include <gtest/gtest.h>

namespace isofront::server {
namespace {

using Segments = std::vector<std::string>;

TEST(Paths, areDecodedAndNeverLeadOut)
{
    EXPECT_EQ(segmentsOf("/"), Segments{""});
    EXPECT_EQ(segmentsOf("/v1/scenes"), (Segments{"v1", "scenes"}));
    EXPECT_EQ(segmentsOf("/a%20b/%C3%A4"), (Segments{"a b", "\xc3\xa4"}));
    EXPECT_EQ(segmentsOf("/a+b"), Segments{"a+b"});
    for (const char* const path :
         {"",
          "v1",
          "http://x/v1",
          "/..",
          "/a/../b",
          "/.",
          "/%2e%2e/etc",
          "/a/%2E%2e",
          "/a%2fb",
          "/a%5cb",
          "/a\\b",
          "/a%00b",
          "/a%0ab",
          "/%",
          "/%4",
          "/%zz",
          "/a%7f"})
        EXPECT_FALSE(segmentsOf(path)) << path;
}

Route routeOf(Method method, const std::string& pattern)
{
    Route route;
    route.method = method;
    route.pattern = pattern;
    return route;
}

TEST(RouteTable, findsByMethodAndPattern)
{
    RouteTable table;
    Api api;
    for (const auto& [method, pattern] : std::vector<std::pair<Method, std::string>>{
             {Method::get, "/v1/scenes"},
             {Method::post, "/v1/scenes"},
             {Method::get, "/v1/scenes/{id}"},
             {Method::remove, "/v1/scenes/{id}"},
             {Method::get, "/tiles/{id}/{path...}"}})
        api.routes.push_back(routeOf(method, pattern));
    table.add(std::move(api));

    const auto found = [&](Method method, const Segments& segments) {
        const RouteTable::Match match = table.find(method, segments);
        return match.route == nullptr
                   ? "none of " + match.allowed
                   : std::string(nameOf(match.route->method)) + " " + match.route->pattern;
    };
    EXPECT_EQ(found(Method::get, {"v1", "scenes"}), "GET /v1/scenes");
    EXPECT_EQ(found(Method::head, {"v1", "scenes"}), "GET /v1/scenes");
    EXPECT_EQ(found(Method::post, {"v1", "scenes"}), "POST /v1/scenes");
    EXPECT_EQ(found(Method::put, {"v1", "scenes"}), "none of GET, HEAD, POST");
    EXPECT_EQ(found(Method::remove, {"v1", "scenes", "7"}), "DELETE /v1/scenes/{id}");
    EXPECT_EQ(found(Method::get, {"v1", "scenes", ""}), "none of ");
    EXPECT_EQ(found(Method::get, {"v1", "scenes", "7", "8"}), "none of ");
    EXPECT_EQ(found(Method::get, {"v1"}), "none of ");
    EXPECT_EQ(table.find(Method::get, {"v1", "scenes", "7"}).parameters.at("id"), "7");
    const auto rest = table.find(Method::get, {"tiles", "7", "a", "b.glb"}).parameters;
    EXPECT_EQ(rest.at("id"), "7");
    EXPECT_EQ(rest.at("path"), "a/b.glb");
}

TEST(Query, isCheckedAgainstWhatTheRouteSays)
{
    Route route = routeOf(Method::get, "/ray/{id}");
    route.parameters = {
        {"id", "of the scene"},
        {"x", "where", Parameter::Kind::number, true},
        {"level", "which", Parameter::Kind::integer},
        {"all", "whether", Parameter::Kind::boolean}};
    const auto fault = [&](std::multimap<std::string, std::string> query) {
        Request request;
        request.parameters["id"] = "7";
        request.query = std::move(query);
        return faultInQuery(route, request).value_or("");
    };
    EXPECT_EQ(fault({{"x", "1.5"}, {"level", "-3"}, {"all", "true"}}), "");
    EXPECT_EQ(fault({{"x", "1e-3"}}), "");
    EXPECT_NE(fault({}).find("'x' is missing"), std::string::npos);
    EXPECT_NE(fault({{"x", "1"}, {"y", "1"}}).find("there are x, level, all"), std::string::npos);
    EXPECT_NE(fault({{"x", "1"}, {"id", "8"}}).find("no parameter 'id'"), std::string::npos);
    EXPECT_NE(fault({{"x", "1"}, {"x", "2"}}).find("more than once"), std::string::npos);
    for (const char* const value : {"", "nan", "inf", "1,5", "0x10", "1 ", " 1", "1e999"})
        EXPECT_NE(fault({{"x", value}}), "") << value;
    EXPECT_NE(fault({{"x", "1"}, {"level", "1.5"}}), "");
    EXPECT_NE(fault({{"x", "1"}, {"all", "yes"}}), "");
}

TEST(Texts, arePlainIfTheyAreUtf8WithoutControlCharacters)
{
    for (const char* const text :
         {"", "a name", "\xc3\xa9", "\xe2\x82\xac", "\xf0\x9f\x90\xb0", "\xf4\x8f\xbf\xbf"})
        EXPECT_TRUE(isPlainText(text)) << text;
    for (const char* const text :
         {"a\nb",
          "\t",
          "\x7f",
          "\x1b[31m",
          "\xc2\x85", // a line's end among the control characters past ASCII
          "\x80",     // the rest of something
          "\xc3",     // cut short
          "\xe2\x82",
          "\xf0\x9f\x90",
          "\xc0\xaf", // a slash, longer than need be
          "\xe0\x80\xaf",
          "\xed\xa0\x80",     // half a pair
          "\xf4\x90\x80\x80", // past the last character
          "\xff"})
        EXPECT_FALSE(isPlainText(text)) << text;
    EXPECT_FALSE(isPlainText(std::string_view("a\0b", 3)));
    // the two of 256 x 256 that a table of UTF-8 has: none but those with a lead and a tail
    int count = 0;
    for (int first = 0x80; first < 0x100; ++first)
        for (int second = 0; second < 0x100; ++second)
            count += isPlainText(std::string{static_cast<char>(first), static_cast<char>(second)});
    EXPECT_EQ(count, 0x1e * 0x40 - 0x20);
}

constexpr const char* kTokens = "# of the lab\n"
                                "read         anna   0123456789abcdef0\n"
                                "read,write   bert   fedcba98765432100\n"
                                "\n"
                                "admin        carl   0123456789abcdef1\n";

TEST(Tokens, areFoundWholeOnly)
{
    const auto tokens = Tokens::parse(kTokens);
    ASSERT_TRUE(tokens) << tokens.error().message;
    EXPECT_EQ(tokens->size(), 3U);
    const auto anna = tokens->principalOf("0123456789abcdef0");
    ASSERT_TRUE(anna);
    EXPECT_EQ(anna->name, "anna");
    EXPECT_TRUE(anna->scopes.contain(Scope::read));
    EXPECT_FALSE(anna->scopes.contain(Scope::write));
    EXPECT_TRUE(tokens->principalOf("fedcba98765432100")->scopes.contain(Scope::write));
    EXPECT_EQ(tokens->principalOf("0123456789abcdef1")->name, "carl");
    for (const std::string& wrong :
         {std::string(),
          std::string("0123456789abcdef"),
          std::string("0123456789abcdef00"),
          std::string("0123456789abcdef2"),
          std::string("0123456789abcdef0\0", 18).append("x"),
          std::string(300, 'a')})
        EXPECT_FALSE(tokens->principalOf(wrong)) << wrong;
    EXPECT_FALSE(Tokens().principalOf("0123456789abcdef0"));
}

TEST(Tokens, refuseFilesThatSaySomethingElse)
{
    for (const char* const text :
         {"read anna",
          "read anna short",
          "root anna 0123456789abcdef0",
          "read",
          "read anna 0123456789abcdef0 more",
          ", anna 0123456789abcdef0",
          "",
          "# read anna 0123456789abcdef0\n\n"})
        EXPECT_FALSE(Tokens::parse(text)) << text;
    for (const std::string text :
         {"0123456789abcdef,x",
          "0123456789abcde==",
          "0123456789abc/def",
          "0123456789abcdef\xc3\xa4"}) {
        const auto odd = Tokens::parse("read anna " + text + "\n");
        ASSERT_FALSE(odd) << text;
        EXPECT_NE(odd.error().message.find("letters, digits"), std::string::npos);
    }
    const auto refused = Tokens::parse("read anna 0123456789abcdef0\nread bert tooshort1\n");
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("line 2"), std::string::npos);
    EXPECT_EQ(refused.error().message.find("tooshort1"), std::string::npos)
        << "messages end up in logs";

    const auto twice = Tokens::parse(std::string(kTokens) + "read dora fedcba98765432100\n");
    ASSERT_FALSE(twice);
    EXPECT_NE(twice.error().message.find("line 6: its token is that of line 3"), std::string::npos)
        << twice.error().message;
    EXPECT_EQ(twice.error().message.find("fedcba"), std::string::npos);

    const TemporaryFolder folder;
    const auto file = folder.write("tokens", kTokens);
    using std::filesystem::perms;
    std::filesystem::permissions(file, perms::owner_read | perms::others_read);
    const auto open = Tokens::read(file);
    ASSERT_FALSE(open);
    EXPECT_NE(open.error().message.find("chmod 600"), std::string::npos);
    std::filesystem::permissions(file, perms::owner_read);
    EXPECT_TRUE(Tokens::read(file));
    EXPECT_FALSE(Tokens::read(folder.path / "none"));
    EXPECT_FALSE(Tokens::read(folder.path));
}

Request requestWith(std::map<std::string, std::string> headers)
{
    Request request;
    request.headers = std::move(headers);
    return request;
}

int statusOf(const std::optional<Response>& refusal)
{
    return refusal ? refusal->status : 0;
}

TEST(Guard, letsNoForeignNameAndNoForeignPageIn)
{
    Settings settings;
    settings.hostNames = {"Scans.Example.org"};
    settings.origins = {"https://lab.example"};
    const Guard guard(settings, {});
    for (const char* const host :
         {"localhost",
          "localhost:8080",
          "LOCALHOST",
          "127.0.0.1:8080",
          "192.168.1.7",
          "[::1]:80",
          "scans.example.org"})
        EXPECT_EQ(statusOf(guard.refuseHost(requestWith({{"host", host}}))), 0) << host;
    for (const char* const host :
         {"", "evil.example", "localhost.evil.example", "127.0.0.1.evil.example", "evil:127"})
        EXPECT_EQ(statusOf(guard.refuseHost(requestWith({{"host", host}}))), 421) << host;

    const auto origin = [&](const char* text) {
        return statusOf(
            guard.refuseOrigin(requestWith({{"host", "localhost:8080"}, {"origin", text}})));
    };
    EXPECT_EQ(origin(""), 0);
    EXPECT_EQ(origin("http://localhost:8080"), 0);
    EXPECT_EQ(origin("https://lab.example"), 0);
    EXPECT_EQ(origin("http://localhost:3000"), 403);
    EXPECT_EQ(origin("https://lab.example.evil"), 403);
    EXPECT_EQ(origin("null"), 403);

    Response response;
    guard.allowReading(requestWith({{"origin", "https://evil.example"}}), response);
    for (const auto& [name, value] : response.headers)
        EXPECT_NE(name, "Access-Control-Allow-Origin");
    guard.allowReading(requestWith({{"origin", "https://lab.example"}}), response);
    EXPECT_EQ(response.headers[2].first, "Access-Control-Allow-Origin");
    EXPECT_EQ(response.headers[2].second, "https://lab.example");
}

TEST(Guard, asksForTheScopeThatIsNeeded)
{
    Settings settings;
    settings.anonymous = {"read"};
    const Guard guard(settings, *Tokens::parse(kTokens));
    const auto status = [&](Scope scope, std::map<std::string, std::string> headers) {
        Request request = requestWith(std::move(headers));
        return statusOf(guard.identify(request, scope));
    };
    EXPECT_EQ(status(Scope::none, {}), 0);
    EXPECT_EQ(status(Scope::read, {}), 0);
    EXPECT_EQ(status(Scope::write, {}), 401);
    EXPECT_EQ(status(Scope::write, {{"authorization", "Bearer fedcba98765432100"}}), 0);
    EXPECT_EQ(status(Scope::write, {{"authorization", "bearer fedcba98765432100"}}), 0);
    EXPECT_EQ(status(Scope::write, {{"authorization", "Bearer 0123456789abcdef0"}}), 403);
    EXPECT_EQ(status(Scope::none, {{"authorization", "Bearer 1123456789abcdef0"}}), 401);
    EXPECT_EQ(status(Scope::read, {{"authorization", "Basic YTpi"}}), 401);
    EXPECT_EQ(
        status(Scope::admin, {{"sec-websocket-protocol", "isofront.v1, bearer.0123456789abcdef1"}}),
        0);
    Request request = requestWith({{"authorization", "Bearer fedcba98765432100"}});
    EXPECT_FALSE(guard.identify(request, Scope::read));
    EXPECT_EQ(request.principal.name, "bert");
}

} // namespace
} // namespace isofront::server
