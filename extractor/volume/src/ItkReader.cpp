#include "ItkReader.h"

#include "Assembly.h"

#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>

#include <cctype>
#include <iostream>
#include <mutex>
#include <optional>
#include <span>
#include <streambuf>
#include <utility>

namespace isofront::volume {

namespace {

using core::ErrorCode;

/// Takes what is written to it and forgets it.
class NullBuffer final : public std::streambuf {
protected:
    int_type overflow(int_type c) override { return traits_type::not_eof(c); }
    std::streamsize xsputn(const char* /*text*/, std::streamsize count) override { return count; }
};

/// Keeps ITK, and MetaIO and VNL below it, from writing to standard error while it lives: what is
/// wrong comes back as an exception, or has been found by our own checks. The libraries write to
/// std::cerr, so that is turned away; what the program says through it meanwhile is lost.
class Silence {
public:
    Silence()
        : _warned(itk::Object::GetGlobalWarningDisplay()), _buffer(std::cerr.rdbuf(&nowhere()))
    {
        itk::Object::SetGlobalWarningDisplay(false);
    }
    Silence(const Silence&) = delete;
    Silence& operator=(const Silence&) = delete;
    ~Silence()
    {
        std::cerr.rdbuf(_buffer);
        itk::Object::SetGlobalWarningDisplay(_warned);
    }

private:
    static NullBuffer& nowhere()
    {
        static NullBuffer buffer;
        return buffer;
    }

    bool _warned;
    std::streambuf* _buffer;
};

itk::ImageIOBase::Pointer readerFor(VolumeFormat format)
{
    switch (format) {
    case VolumeFormat::nrrd:
        return itk::NrrdImageIO::New().GetPointer();
    case VolumeFormat::metaImage:
        return itk::MetaImageIO::New().GetPointer();
    default:
        return nullptr;
    }
}

/// The last sentence of ITK's many-line messages says what went wrong.
std::string reasonOf(const itk::ExceptionObject& exception)
{
    std::string reason = exception.GetDescription();
    while (!reason.empty() && std::isspace(static_cast<unsigned char>(reason.back())) != 0)
        reason.pop_back();
    reason.erase(0, reason.find_last_of('\n') + 1);
    return reason;
}

/// The type with this many bytes of the kind that ITK names, which depends on the platform's
/// `long`.
std::optional<raster::SampleType> sampleTypeOf(itk::IOComponentEnum component, std::size_t bytes)
{
    using Component = itk::IOComponentEnum;
    using raster::SampleType;
    switch (component) {
    case Component::FLOAT:
        return SampleType::float32;
    case Component::DOUBLE:
        return SampleType::float64;
    case Component::CHAR:
    case Component::SHORT:
    case Component::INT:
    case Component::LONG:
    case Component::LONGLONG:
        return bytes == 1   ? std::optional(SampleType::int8)
               : bytes == 2 ? std::optional(SampleType::int16)
               : bytes == 4 ? std::optional(SampleType::int32)
               : bytes == 8 ? std::optional(SampleType::int64)
                            : std::nullopt;
    case Component::UCHAR:
    case Component::USHORT:
    case Component::UINT:
    case Component::ULONG:
    case Component::ULONGLONG:
        return bytes == 1   ? std::optional(SampleType::uint8)
               : bytes == 2 ? std::optional(SampleType::uint16)
               : bytes == 4 ? std::optional(SampleType::uint32)
               : bytes == 8 ? std::optional(SampleType::uint64)
                            : std::nullopt;
    default:
        return std::nullopt;
    }
}

} // namespace

core::Result<DenseVoxels> readThroughItk(
    const std::filesystem::path& path,
    VolumeFormat format,
    const FileHeader& checked,
    const LoadOptions& options)
{
    // The libraries beneath, teem first of all, collect their messages in global variables.
    static std::mutex oneAtATime;
    const std::lock_guard lock(oneAtATime);
    const Silence silence;

    try {
        const itk::ImageIOBase::Pointer reader = readerFor(format);
        reader->SetFileName(path.string());
        reader->ReadImageInformation();

        DenseVoxels result;
        FileHeader header; // what ITK has understood must pass the same checks
        const unsigned axes = reader->GetNumberOfDimensions();
        itk::ImageIORegion region(axes);
        for (unsigned axis = 0; axis < axes; ++axis) {
            const auto size = reader->GetDimensions(axis);
            region.SetSize(axis, size);
            region.SetIndex(axis, 0);
            if (axis < 3)
                header.dimensions[axis] = static_cast<std::int64_t>(size);
            if (axes < 3 || (axis >= 3 && size != 1) || reader->GetNumberOfComponents() != 1)
                return core::failure(
                    ErrorCode::badData,
                    "only three-dimensional volumes with one value a voxel can be read");
        }
        const std::size_t bytes = reader->GetComponentSize();
        const auto type = sampleTypeOf(reader->GetComponentType(), bytes);
        if (!type)
            return core::failure(
                ErrorCode::badData,
                "voxels of type " +
                    itk::ImageIOBase::GetComponentTypeAsString(reader->GetComponentType()) +
                    " can't be read; convert them to integers, float or double");
        header.voxelBytes = bytes;
        if (const auto good = checkHeader(header, options.memoryLimit); !good)
            return tl::unexpected(good.error());
        if (const auto good = checkStop(options); !good)
            return tl::unexpected(good.error());

        for (unsigned axis = 0; axis < 3; ++axis) {
            result.dimensions[axis] = static_cast<int>(header.dimensions[axis]);
            result.worldFromIndex.translation[axis] = reader->GetOrigin(axis);
            const std::vector<double> direction = reader->GetDirection(axis);
            for (unsigned row = 0; row < 3; ++row)
                result.worldFromIndex.linear[axis][row] =
                    direction.at(row) * reader->GetSpacing(axis);
        }
        reader->SetIORegion(region);
        auto voxels = readVoxels(
            *type,
            header.dataBytes() / bytes,
            result.notes,
            [&](std::span<std::byte> into) -> core::Result<void> {
                if (format == VolumeFormat::metaImage && into.size() == checked.dataBytes() &&
                    checked.encoding == FileHeader::Encoding::deflate)
                    return readCompressedData(checked, into);
                reader->Read(into.data());
                return {};
            });
        if (!voxels)
            return tl::unexpected(voxels.error());
        result.voxels = std::move(*voxels);
        return result;
    } catch (const itk::ExceptionObject& exception) {
        return core::failure(
            ErrorCode::badData,
            "the file can't be read as " + std::string(nameOf(format)) + ": " +
                reasonOf(exception));
    }
}

} // namespace isofront::volume
