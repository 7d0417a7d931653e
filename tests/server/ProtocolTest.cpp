// The messages of docs/protocol.md against vectors that were not made with this code.

#include "stream/Protocol.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace isofront::server::protocol {
namespace {

std::map<std::string, std::vector<std::byte>> vectors()
{
    std::map<std::string, std::vector<std::byte>> all;
    std::ifstream file(ISOFRONT_VECTORS "/messages.txt");
    for (std::string line; std::getline(file, line);) {
        const std::size_t space = line.find(' ');
        if (line.starts_with('#') || space == std::string::npos)
            continue;
        std::vector<std::byte>& bytes = all[line.substr(0, space)];
        for (std::size_t i = space + 1; i + 1 < line.size(); i += 2)
            bytes.push_back(static_cast<std::byte>(std::stoi(line.substr(i, 2), nullptr, 16)));
    }
    return all;
}

template <typename Message>
Message parsed(const std::string& name)
{
    const auto message = parse(vectors().at(name));
    EXPECT_TRUE(message) << message.error().message;
    return message ? std::get<Message>(*message) : Message{};
}

TEST(Protocol, readsTheVectorsOfClients)
{
    const auto hello = parsed<Hello>("hello");
    EXPECT_EQ(hello.cacheBytes, 1'000'000U);
    ASSERT_EQ(hello.held.size(), 2U);
    EXPECT_EQ(hello.held[0].hash, 0x0123456789abcdefU);
    EXPECT_EQ(hello.held[0].bytes, 300U);
    EXPECT_EQ(hello.held[1].hash, 7U);
    const auto view = parsed<ViewChange>("view");
    EXPECT_EQ(view.view.width, 1280);
    EXPECT_EQ(view.view.height, 720);
    EXPECT_EQ(view.view.eye, glm::dvec3(1, 2, 3));
    EXPECT_EQ(view.view.forward, glm::dvec3(0, 1, 0));
    EXPECT_EQ(view.view.up, glm::dvec3(0, 0, 1));
    EXPECT_EQ(view.view.verticalFieldOfView, 1.0);
    EXPECT_EQ(view.pixelError, 2.5);
    EXPECT_EQ(parsed<IsovalueChange>("isovalue").isovalue, 300.25);
    const auto focus = parsed<FocusChange>("focus");
    ASSERT_EQ(focus.focus.size(), 1U);
    EXPECT_EQ(focus.focus[0].box.high, glm::dvec3(1, 2, 3));
    EXPECT_EQ(focus.focus[0].radius, 4);
    EXPECT_EQ(focus.focus[0].error, 0.5);
    EXPECT_EQ(focus.focus[0].falloff, 0.125);
    EXPECT_EQ(parsed<Credits>("credits").bytes, std::uint64_t{1} << 20U);
    EXPECT_EQ(parsed<Acknowledgement>("acknowledge").transaction, 9U);
}

TEST(Protocol, refusesVectorsThatAreCutOrGoOn)
{
    for (const auto& [name, bytes] : vectors()) {
        for (std::size_t size = 0; size < bytes.size(); ++size)
            EXPECT_FALSE(parse(std::span(bytes).first(size))) << name << " " << size;
        auto longer = bytes;
        longer.push_back(std::byte{0});
        EXPECT_FALSE(parse(longer)) << name;
    }
}

TEST(Protocol, writesTheVectorsOfTheService)
{
    const auto all = vectors();
    Welcome welcome;
    welcome.domain = {
        glm::dvec3(1, 2, 3), 64, {glm::dmat3(1, 0, 0, 0, 2, 0, 0, 0, 3), glm::dvec3(4, 5, 6)}};
    welcome.isovalue = 300.25;
    welcome.bounds = {glm::dvec3(0), glm::dvec3(10, 20, 30)};
    welcome.eye = {7, 8, 9};
    welcome.target = {5, 5, 5};
    EXPECT_EQ(encode(welcome), all.at("welcome"));

    const std::vector<hierarchy::CellId> removed{{{1U << 30U, 1U << 30U, 3}, 4}};
    const std::vector<AddedCell> added{{{{5, 6, 7}, 1}, 0x0123456789abcdef}};
    const std::vector<std::uint64_t> forgotten{11};
    EXPECT_EQ(
        encode(TransactionPart{true, true, 5, 300.25, 2.5, 12, removed, added, forgotten}),
        all.at("transaction"));
    EXPECT_EQ(encodeError({core::ErrorCode::badData, "why?"}), all.at("error"));
}

} // namespace
} // namespace isofront::server::protocol
