!> The calls of insitu_mesh that take real64 arrays.
module insitu_real64
  use, intrinsic :: iso_c_binding, only: c_loc, c_null_ptr, c_ptr
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64
  use insitu_arrays, only: array_of, nothing
  use insitu_c, only: c_array, c_block, insitu_block_rectilinear, insitu_cell, insitu_ok, &
      insitu_vertex, wp_type => insitu_float64
  use insitu_real32, only: below => mesh_of_reals
  implicit none
  private

  integer, parameter :: wp = real64

  type, extends(below), public :: mesh_of_reals
  contains
    procedure, private :: points_interleaved_r64 => points_interleaved
    procedure, private :: points_1_r64 => points_1
    procedure, private :: points_2_r64 => points_2
    procedure, private :: curvilinear_interleaved_r64 => curvilinear_interleaved
    procedure, private :: curvilinear_3_r64 => curvilinear_3
    procedure, private :: rectilinear_r64 => rectilinear
    procedure, private :: flat_points_r64 => flat_points_1
    procedure, private :: flat_curvilinear_r64 => flat_curvilinear
    procedure, private :: flat_rectilinear_r64 => flat_rectilinear
    procedure, private :: vertex_1_r64 => vertex_1
    procedure, private :: vertex_2_r64 => vertex_2
    procedure, private :: vertex_3_r64 => vertex_3
    procedure, private :: vertex_4_r64 => vertex_4
    procedure, private :: vertex_uvw_1_r64 => vertex_uvw_1
    procedure, private :: vertex_uvw_2_r64 => vertex_uvw_2
    procedure, private :: vertex_uvw_3_r64 => vertex_uvw_3
    procedure, private :: cell_1_r64 => cell_1
    procedure, private :: cell_2_r64 => cell_2
    procedure, private :: cell_3_r64 => cell_3
    procedure, private :: cell_4_r64 => cell_4
    procedure, private :: cell_uvw_1_r64 => cell_uvw_1
    procedure, private :: cell_uvw_2_r64 => cell_uvw_2
    procedure, private :: cell_uvw_3_r64 => cell_uvw_3
    procedure, private :: locate_interleaved_r64 => locate_interleaved
    procedure, private :: locate_1_r64 => locate_1
    procedure, private :: locate_interleaved_int32_r64 => locate_interleaved_int32
    procedure, private :: locate_1_int32_r64 => locate_1_int32
    procedure, private :: sample_interleaved_r64 => sample_interleaved
    procedure, private :: sample_interleaved_vector_r64 => sample_interleaved_vector
    procedure, private :: sample_1_r64 => sample_1
    procedure, private :: sample_1_vector_r64 => sample_1_vector
    procedure, private :: nearest_interleaved_r64 => nearest_interleaved
    procedure, private :: nearest_1_r64 => nearest_1
    generic :: points => points_interleaved_r64, points_1_r64, points_2_r64
    generic :: curvilinear_block => curvilinear_interleaved_r64, curvilinear_3_r64
    generic :: rectilinear_block => rectilinear_r64
    generic :: flat_points => flat_points_r64
    generic :: flat_curvilinear_block => flat_curvilinear_r64
    generic :: flat_rectilinear_block => flat_rectilinear_r64
    generic :: vertex_field => vertex_1_r64, vertex_2_r64, vertex_3_r64, vertex_4_r64, &
        vertex_uvw_1_r64, vertex_uvw_2_r64, vertex_uvw_3_r64
    generic :: cell_field => cell_1_r64, cell_2_r64, cell_3_r64, cell_4_r64, cell_uvw_1_r64, &
        cell_uvw_2_r64, cell_uvw_3_r64
    generic :: locate => locate_interleaved_r64, locate_1_r64, locate_interleaved_int32_r64, &
        locate_1_int32_r64
    generic :: sample => sample_interleaved_r64, sample_interleaved_vector_r64, sample_1_r64, &
        sample_1_vector_r64
    generic :: nearest_vertices => nearest_interleaved_r64, nearest_1_r64
  end type mesh_of_reals

contains

  include 'insitu_reals.inc'
  include 'insitu_queries.inc'

end module insitu_real64
