#pragma once

#include "stream/CellCodec.h"
#include "surface/LiveSurfaceFixture.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace isofront::server {

/// Writes and reads what docs/protocol.md says, on its own.
class Bytes {
public:
    template <typename Number>
    Bytes& put(Number number)
    {
        const std::size_t at = bytes.size();
        bytes.resize(at + sizeof number);
        std::memcpy(bytes.data() + at, &number, sizeof number);
        return *this;
    }
    std::vector<std::byte> bytes;
};

inline std::vector<std::byte>
helloMessage(std::uint64_t cache, const std::map<std::uint64_t, std::uint32_t>& held = {})
{
    Bytes message;
    message.put(std::uint8_t{1}).put(std::uint8_t{1}).put(std::uint16_t{0}).put(cache);
    message.put(static_cast<std::uint32_t>(held.size()));
    for (const auto& [hash, size] : held)
        message.put(hash).put(size);
    return message.bytes;
}

inline std::vector<std::byte> viewMessage(const hierarchy::View& view, double pixelError)
{
    Bytes message;
    message.put(std::uint32_t{2}).put(view.width).put(view.height);
    for (const glm::dvec3& v : {view.eye, view.forward, view.up})
        message.put(v.x).put(v.y).put(v.z);
    return message.put(view.verticalFieldOfView).put(pixelError).bytes;
}

inline std::vector<std::byte> isovalueMessage(double isovalue)
{
    return Bytes().put(std::uint64_t{3}).put(isovalue).bytes;
}

inline std::vector<std::byte> focusMessage(const core::Box& box, double radius, double error)
{
    Bytes message;
    message.put(std::uint8_t{4}).put(std::uint8_t{1}).put(std::uint16_t{0});
    for (const glm::dvec3& v : {box.low, box.high})
        message.put(v.x).put(v.y).put(v.z);
    return message.put(radius).put(error).put(0.0).bytes;
}

inline std::vector<std::byte> creditsMessage(std::uint64_t bytes)
{
    return Bytes().put(std::uint64_t{5}).put(bytes).bytes;
}

inline std::vector<std::byte> acknowledgeMessage(std::uint64_t transaction)
{
    return Bytes().put(std::uint64_t{6}).put(transaction).bytes;
}

/// A client that believes nothing: each message must be what the protocol says, and each
/// transaction must lead from one closed surface to another.
class StreamClient {
public:
    struct Payload {
        std::shared_ptr<const extractor::CellMesh> mesh;
        std::uint32_t bytes = 0;
    };

    void take(std::span<const std::byte> message)
    {
        _left = message;
        const auto type = get<std::uint8_t>();
        if (type == 0x81)
            takeWelcome();
        else if (type == 0x82)
            takeCells(message.size());
        else if (type == 0x83)
            takeTransaction();
        else if (type == 0xff)
            takeError();
        else
            ADD_FAILURE() << "type " << int{type};
        EXPECT_TRUE(_left.empty()) << "bytes behind a message of type " << int{type};
        if (type == 0x82 || type == 0x83)
            charged += message.size();
        received += message.size();
    }

    bool isWelcomed = false;
    std::string error;
    std::uint64_t transaction = 0; ///< the last
    bool isSettled = false;
    double isovalue = 0;
    double pixelError = 0;
    std::uint64_t charged = 0; ///< bytes that take credits
    std::uint64_t received = 0;
    std::uint64_t cellBytes = 0;
    std::size_t cells = 0;         ///< received
    std::size_t cellTriangles = 0; ///< of them
    std::map<std::uint64_t, Payload> payloads;
    surface::Host host;
    bool looksForCracks = true;

private:
    template <typename Number>
    Number get()
    {
        Number number{};
        EXPECT_GE(_left.size(), sizeof number) << "a message ends too early";
        if (_left.size() < sizeof number)
            return number;
        std::memcpy(&number, _left.data(), sizeof number);
        _left = _left.subspan(sizeof number);
        return number;
    }
    hierarchy::CellId getId()
    {
        hierarchy::CellId id;
        id.spine.x = get<std::uint32_t>();
        id.spine.y = get<std::uint32_t>();
        id.spine.z = get<std::uint32_t>();
        id.index = get<std::uint8_t>();
        return id;
    }
    void takeWelcome()
    {
        EXPECT_FALSE(isWelcomed);
        isWelcomed = true;
        EXPECT_EQ(get<std::uint8_t>(), 1);
        EXPECT_EQ(get<std::uint16_t>(), 0);
        EXPECT_EQ(get<std::uint32_t>(), 65536U);
        for (int i = 0; i < 4 + 12; ++i)
            get<double>();
        isovalue = get<double>();
        for (int i = 0; i < 15; ++i)
            get<double>();
    }
    void takeCells(std::size_t size)
    {
        EXPECT_EQ(get<std::uint8_t>(), 0);
        EXPECT_EQ(get<std::uint16_t>(), 0);
        const auto count = get<std::uint32_t>();
        EXPECT_GT(count, 0U);
        EXPECT_TRUE(count == 1 || size <= 65536U);
        for (std::uint32_t i = 0; i < count && !testing::Test::HasFailure(); ++i) {
            const auto hash = get<std::uint64_t>();
            const auto length = get<std::uint32_t>();
            ASSERT_LE(length, _left.size());
            const auto bytes = _left.first(length);
            _left = _left.subspan(length);
            EXPECT_EQ(hashOf(bytes), hash);
            const auto mesh = decodeCell(bytes);
            ASSERT_TRUE(mesh) << mesh.error().message;
            EXPECT_FALSE(payloads.contains(hash)) << "sent although it is here";
            cellTriangles += mesh->triangleCount();
            payloads[hash] = {std::make_shared<const extractor::CellMesh>(*mesh), length};
            ++cells;
            cellBytes += length;
        }
    }
    void takeTransaction()
    {
        const auto flags = get<std::uint8_t>();
        EXPECT_EQ(get<std::uint16_t>(), 0);
        const auto removed = get<std::uint32_t>();
        const auto added = get<std::uint32_t>();
        const auto forgotten = get<std::uint32_t>();
        const auto id = get<std::uint64_t>();
        isovalue = get<double>();
        pixelError = get<double>();
        EXPECT_GE(get<double>(), 0);
        EXPECT_EQ(id, transaction + 1);
        for (std::uint32_t i = 0; i < removed; ++i)
            _delta.removed.push_back(getId());
        for (std::uint32_t i = 0; i < added; ++i) {
            const hierarchy::CellId cell = getId();
            const auto hash = get<std::uint64_t>();
            ASSERT_TRUE(payloads.contains(hash)) << "shows what isn't here";
            _delta.added.emplace_back(cell, payloads.at(hash).mesh);
        }
        for (std::uint32_t i = 0; i < forgotten; ++i)
            _forgotten.push_back(get<std::uint64_t>());
        if ((flags & 1U) == 0)
            return;
        transaction = id;
        isSettled = (flags & 2U) != 0;
        _delta.steps = {{hierarchy::kRootDiamond, _delta.removed.size(), _delta.added.size()}};
        if (!_delta.isEmpty())
            host.apply(_delta);
        if (looksForCracks) {
            EXPECT_EQ(host.cracks(), 0U) << "after transaction " << id;
        }
        for (const std::uint64_t hash : _forgotten)
            EXPECT_EQ(payloads.erase(hash), 1U);
        _delta = {};
        _forgotten.clear();
    }
    void takeError()
    {
        get<std::uint8_t>();
        get<std::uint16_t>();
        const auto length = get<std::uint32_t>();
        ASSERT_LE(length, _left.size());
        error.assign(reinterpret_cast<const char*>(_left.data()), length);
        _left = _left.subspan(length);
    }

    std::span<const std::byte> _left;
    surface::Delta _delta;
    std::vector<std::uint64_t> _forgotten;
};

} // namespace isofront::server
