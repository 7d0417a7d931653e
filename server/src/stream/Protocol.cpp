#include "Protocol.h"

#include "Bytes.h"

#include <algorithm>
#include <cmath>

namespace isofront::server::protocol {
namespace {

constexpr std::int32_t kMostPixels = 1 << 16;

tl::unexpected<core::Error> wrong(const std::string& why)
{
    return core::failure(core::ErrorCode::badData, why + " (see docs/protocol.md, version 1)");
}

glm::dvec3 getVector(ByteReader& reader)
{
    glm::dvec3 vector;
    for (std::size_t axis = 0; axis < 3; ++axis)
        vector[axis] = reader.get<double>();
    return vector;
}

void put(ByteWriter& writer, const glm::dvec3& vector)
{
    writer.put(vector.x).put(vector.y).put(vector.z);
}

void put(ByteWriter& writer, const hierarchy::CellId& id)
{
    writer.put(id.spine.x).put(id.spine.y).put(id.spine.z).put(id.index);
}

bool isFinite(const glm::dvec3& v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

core::Result<ClientMessage> parseHello(ByteReader& reader)
{
    const auto version = reader.get<std::uint8_t>();
    reader.get(2);
    Hello hello;
    hello.cacheBytes = reader.get<std::uint64_t>();
    const std::size_t count = reader.get<std::uint32_t>();
    if (!reader.isWhole())
        return wrong("the hello ends too early");
    if (version != kVersion)
        return wrong(
            "the client speaks version " + std::to_string(version) + ", the service " +
            std::to_string(kVersion));
    if (reader.left() != 12 * count)
        return wrong("the hello is not as long as its list of payloads");
    for (std::size_t i = 0; i < count; ++i) {
        const auto hash = reader.get<std::uint64_t>();
        hello.held.push_back({hash, reader.get<std::uint32_t>()});
    }
    return hello;
}

core::Result<ClientMessage> parseView(ByteReader& reader)
{
    reader.get(3);
    ViewChange change;
    change.view.width = reader.get<std::int32_t>();
    change.view.height = reader.get<std::int32_t>();
    change.view.eye = getVector(reader);
    change.view.forward = getVector(reader);
    change.view.up = getVector(reader);
    change.view.verticalFieldOfView = reader.get<double>();
    change.pixelError = reader.get<double>();
    if (!change.view.isValid() || change.view.width > kMostPixels ||
        change.view.height > kMostPixels)
        return wrong("the view makes no sense");
    if (!(change.pixelError > 0))
        return wrong("the error to allow must be above 0 px");
    change.pixelError = std::clamp(change.pixelError, kLeastPixelError, kMostPixelError);
    return change;
}

core::Result<ClientMessage> parseFocus(ByteReader& reader)
{
    const std::size_t count = reader.get<std::uint8_t>();
    reader.get(2);
    if (count > kMostFocuses)
        return wrong("there are more than " + std::to_string(kMostFocuses) + " areas of interest");
    FocusChange change;
    for (std::size_t i = 0; i < count; ++i) {
        hierarchy::Focus focus;
        focus.box.low = getVector(reader);
        focus.box.high = getVector(reader);
        focus.radius = reader.get<double>();
        focus.error = reader.get<double>();
        focus.falloff = reader.get<double>();
        const bool isSound = isFinite(focus.box.low) && isFinite(focus.box.high) &&
                             !focus.box.isEmpty() && std::isfinite(focus.radius) &&
                             focus.radius >= 0 && std::isfinite(focus.error) && focus.error > 0 &&
                             std::isfinite(focus.falloff) && focus.falloff >= 0;
        if (reader.isWhole() && !isSound)
            return wrong("an area of interest makes no sense");
        change.focus.push_back(focus);
    }
    return change;
}

core::Result<ClientMessage> parseIsovalue(ByteReader& reader)
{
    reader.get(7);
    const auto isovalue = reader.get<double>();
    if (!std::isfinite(isovalue))
        return wrong("the isovalue is no number");
    return IsovalueChange{isovalue};
}

core::Result<ClientMessage> parseBody(ClientType type, ByteReader& reader)
{
    switch (type) {
    case ClientType::hello:
        return parseHello(reader);
    case ClientType::view:
        return parseView(reader);
    case ClientType::isovalue:
        return parseIsovalue(reader);
    case ClientType::focus:
        return parseFocus(reader);
    case ClientType::credits:
        reader.get(7);
        return Credits{reader.get<std::uint64_t>()};
    case ClientType::acknowledge:
        reader.get(7);
        return Acknowledgement{reader.get<std::uint64_t>()};
    }
    return wrong("there is no message of that type");
}

} // namespace

core::Result<ClientMessage> parse(std::span<const std::byte> message)
{
    if (message.empty())
        return wrong("messages are binary and not empty");
    ByteReader reader(message);
    const auto type = reader.get<std::uint8_t>();
    auto parsed = parseBody(static_cast<ClientType>(type), reader);
    if (parsed && (!reader.isWhole() || reader.left() != 0))
        return wrong("a message of type " + std::to_string(type) + " isn't as long as it must be");
    return parsed;
}

std::vector<std::byte> encode(const Welcome& welcome)
{
    ByteWriter writer;
    writer.put(static_cast<std::uint8_t>(ServerType::welcome)).put(kVersion);
    writer.put(std::uint16_t{0}).put(static_cast<std::uint32_t>(kLongestMessage));
    put(writer, welcome.domain.origin);
    writer.put(welcome.domain.edge);
    for (std::size_t column = 0; column < 3; ++column)
        put(writer, welcome.domain.worldFromField.linear[column]);
    put(writer, welcome.domain.worldFromField.translation);
    writer.put(welcome.isovalue);
    put(writer, welcome.bounds.low);
    put(writer, welcome.bounds.high);
    put(writer, welcome.eye);
    put(writer, welcome.target);
    put(writer, welcome.up);
    return writer.take();
}

std::vector<std::byte> encode(const TransactionPart& part)
{
    ByteWriter writer;
    writer.put(static_cast<std::uint8_t>(ServerType::transaction));
    writer.put(static_cast<std::uint8_t>((part.isLast ? 1U : 0U) | (part.isSettled ? 2U : 0U)));
    writer.put(std::uint16_t{0});
    writer.put(static_cast<std::uint32_t>(part.removed.size()));
    writer.put(static_cast<std::uint32_t>(part.added.size()));
    writer.put(static_cast<std::uint32_t>(part.forgotten.size()));
    writer.put(part.id).put(part.isovalue).put(part.pixelError).put(part.milliseconds);
    for (const hierarchy::CellId& id : part.removed)
        put(writer, id);
    for (const AddedCell& cell : part.added) {
        put(writer, cell.id);
        writer.put(cell.hash);
    }
    for (const std::uint64_t hash : part.forgotten)
        writer.put(hash);
    return writer.take();
}

std::vector<std::byte> encodeError(const core::Error& error)
{
    ByteWriter writer;
    writer.put(static_cast<std::uint8_t>(ServerType::error));
    writer.put(static_cast<std::uint8_t>(error.code)).put(std::uint16_t{0});
    writer.put(static_cast<std::uint32_t>(error.message.size()));
    writer.put(std::as_bytes(std::span(error.message)));
    return writer.take();
}

} // namespace isofront::server::protocol
