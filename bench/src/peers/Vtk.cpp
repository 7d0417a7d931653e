#include "peers/Vtk.h"

#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSMPTools.h>
#include <vtkVersion.h>

namespace isofront::bench::peers {

VtkMesh flyingEdges(
    const std::vector<float>& values,
    const std::array<int, 3>& count,
    const std::array<double, 3>& origin,
    double spacing,
    double isovalue)
{
    vtkSMPTools::Initialize(1);
    vtkNew<vtkFloatArray> scalars;
    // VTK takes no pointer to const; the filter only reads
    scalars->SetArray(const_cast<float*>(values.data()), static_cast<vtkIdType>(values.size()), 1);
    vtkNew<vtkImageData> image;
    image->SetDimensions(count[0], count[1], count[2]);
    image->SetOrigin(origin[0], origin[1], origin[2]);
    image->SetSpacing(spacing, spacing, spacing);
    image->GetPointData()->SetScalars(scalars);
    vtkNew<vtkFlyingEdges3D> filter;
    filter->SetInputData(image);
    filter->SetValue(0, isovalue);
    filter->ComputeNormalsOn();
    filter->ComputeGradientsOff();
    filter->ComputeScalarsOff();
    filter->Update();

    VtkMesh mesh;
    vtkPolyData* const output = filter->GetOutput();
    const vtkIdType points = output->GetNumberOfPoints();
    vtkDataArray* const normals = output->GetPointData()->GetNormals();
    for (vtkIdType i = 0; i < points; ++i) {
        double at[3];
        output->GetPoint(i, at);
        mesh.positions.insert(mesh.positions.end(), at, at + 3);
        if (normals != nullptr) {
            normals->GetTuple(i, at);
            for (const double value : at)
                mesh.normals.push_back(static_cast<float>(value));
        }
    }
    vtkCellArray* const polygons = output->GetPolys();
    polygons->InitTraversal();
    vtkIdType corners = 0;
    const vtkIdType* ids = nullptr;
    while (polygons->GetNextCell(corners, ids) != 0)
        if (corners == 3)
            for (int k = 0; k < 3; ++k)
                mesh.indices.push_back(static_cast<std::uint32_t>(ids[k]));
    return mesh;
}

std::string vtkVersion()
{
    return ::vtkVersion::GetVTKVersion();
}

} // namespace isofront::bench::peers
