#include "GraphFiles.h"

#include <isofront/elevation/LoadElevation.h>
#include <isofront/fields/Embed.h>
#include <isofront/volume/LoadVolume.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace isofront::sources {

namespace {

using fields::graph::FileRequest;
using LoadedField = core::Result<std::shared_ptr<const fields::Field>>;

class Loader {
public:
    Loader(std::uint64_t memoryLimit, std::stop_token stop)
        : _memoryLeft(memoryLimit), _stop(std::move(stop))
    {
    }

    LoadedField load(const FileRequest& request)
    {
        return request.kind == FileRequest::Kind::elevation ? elevationOf(request)
                                                            : volumeOf(request);
    }

private:
    LoadedField elevationOf(const FileRequest& request)
    {
        elevation::ElevationOptions options{.memoryLimit = _memoryLeft, .stop = _stop};
        if (request.pixelSize)
            options.pixelSize = glm::dvec2(*request.pixelSize);
        options.heightScale = request.heightScale;
        options.noData = request.noData;
        auto loaded = elevation::loadElevation(request.path, options);
        if (!loaded)
            return tl::unexpected<core::Error>(loaded.error());
        take(loaded->info.memoryBytes);
        return loaded->field;
    }

    LoadedField volumeOf(const FileRequest& request)
    {
        auto loaded = volume::loadVolume(
            request.path, {.memoryLimit = _memoryLeft, .gridName = request.grid, .stop = _stop});
        if (!loaded)
            return tl::unexpected<core::Error>(loaded.error());
        take(loaded->info.memoryBytes);
        const volume::ValueSummary& values = loaded->info.values;
        const double isovalue = request.isovalue.value_or(loaded->info.suggestedIsovalue);
        // From the least value to the largest within one voxel: as steep as data can be.
        const double range = values.high - values.low;
        return fields::embedded(
            loaded->field,
            {loaded->worldFromIndex,
             volume::fieldIsovalue(*loaded, isovalue),
             range > 0 ? range : 1.0});
    }

    void take(std::uint64_t bytes) { _memoryLeft -= std::min(bytes, _memoryLeft); }

    std::uint64_t _memoryLeft;
    std::stop_token _stop;
};

} // namespace

fields::graph::FileLoader graphFileLoader(std::uint64_t memoryLimit, std::stop_token stop)
{
    return [loader = std::make_shared<Loader>(memoryLimit, std::move(stop))](
               const FileRequest& request) { return loader->load(request); };
}

} // namespace isofront::sources
