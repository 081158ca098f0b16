"""Writes a film of WIDTH x HEIGHT pixels with the planes of a render: make.py FILE.exr WIDTH HEIGHT

Needs the packages OpenEXR and numpy.
"""
import sys, numpy as np, OpenEXR
w,h=int(sys.argv[2]),int(sys.argv[3])
rng=np.random.default_rng(1)
y,x=np.mgrid[0:h,0:w].astype(np.float32)
base=(0.5+0.4*np.sin(x/97)*np.cos(y/61)).astype(np.float32)
noise=rng.random((h,w),dtype=np.float32)
ch={}
for c,k in zip("RGB",(1.0,.8,.6)): ch[c]=base*k*(1+0.01*noise)
ch["half_width.Y"]=base*0.02*noise
ch["standard_error.Y"]=ch["half_width.Y"]/2
ch["claim.id"]=np.full((h,w),3,np.uint32)
ch["stop.id"]=np.full((h,w),3,np.uint32)
ch["pairs.n"]=np.floor(700*noise).astype(np.float32)
ch["rays.n"]=np.floor(1500*noise).astype(np.float32)
ch["depth.Z"]=x/100
for c in "XYZ": ch["normal."+c]=base
for c in "RGB": ch["albedo."+c]=base
ch["coverage.A"]=np.ones((h,w),np.float32)
OpenEXR.File({"compression":OpenEXR.ZIP_COMPRESSION,"type":OpenEXR.scanlineimage},ch).write(sys.argv[1])
