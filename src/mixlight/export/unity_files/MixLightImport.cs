// Sets a scene up with the light of unity.json and the map environment.hdr beside it:
// GameObject > Light > MixLight... Derived from Unity's documentation; never run in Unity itself.

using System;
using System.IO;
using UnityEditor;
using UnityEngine;
using UnityEngine.Rendering;

public static class MixLightImport
{
    [Serializable]
    public class Harmonics
    {
        public string kind;
        public string frame;
        public string layout;
        public float[] coefficients;
    }

    [Serializable]
    public class HarmonicsPair
    {
        public Harmonics ambient;
        public Harmonics all_light;
    }

    [Serializable]
    public class NamedLight
    {
        public string name;
        public float[] direction;
        public float[] irradiance;
        public float angular_diameter_deg;
        public bool enabled;
    }

    [Serializable]
    public class Rig
    {
        public string format;
        public int version;
        public string name;
        public string frame;
        public string map;
        public float exposure_gain;
        public NamedLight[] lights;
        public HarmonicsPair harmonics;
    }

    [MenuItem("GameObject/Light/MixLight...", false, 40)]
    public static void Choose()
    {
        string path = EditorUtility.OpenFilePanel("Light of MixLight", Application.dataPath, "json");
        if (string.IsNullOrEmpty(path))
        {
            return;
        }
        string assets = Application.dataPath.Replace('\\', '/');
        path = path.Replace('\\', '/');
        if (!path.StartsWith(assets + "/", StringComparison.Ordinal))
        {
            throw new ArgumentException("expected a file below Assets, received " + path);
        }
        Build("Assets" + path.Substring(assets.Length));
    }

    public static GameObject Build(string assetPath)
    {
        Rig rig = JsonUtility.FromJson<Rig>(File.ReadAllText(assetPath));
        if (rig == null || rig.format != "mixlight/unity" || rig.version != 1)
        {
            throw new ArgumentException(assetPath + ": expected mixlight/unity of version 1");
        }
        if (QualitySettings.activeColorSpace != ColorSpace.Linear)
        {
            Debug.LogWarning("MixLight: the project is not in linear colour space; light will not add up.");
        }
        string map = Path.GetDirectoryName(assetPath).Replace('\\', '/') + "/environment.hdr";
        RenderSettings.skybox = Sky(map, rig.name);
        RenderSettings.ambientMode = AmbientMode.Custom;
        RenderSettings.ambientProbe = Probe(rig.harmonics.ambient);
        RenderSettings.defaultReflectionMode = DefaultReflectionMode.Skybox;

        GameObject root = new GameObject(rig.name);
        Undo.RegisterCreatedObjectUndo(root, "MixLight");
        foreach (NamedLight light in rig.lights)
        {
            Directional(light, root.transform);
        }
        DynamicGI.UpdateEnvironment();
        return root;
    }

    // sh[channel, index] takes what the shader multiplies 1, y, z, x, xy, yz, 3z^2-1, xz, x^2-y^2 with.
    public static SphericalHarmonicsL2 Probe(Harmonics harmonics)
    {
        if (harmonics.layout != "planar" || harmonics.frame != "unity" || harmonics.coefficients.Length != 27)
        {
            throw new ArgumentException("expected 27 planar harmonics in Unity's axes");
        }
        SphericalHarmonicsL2 probe = new SphericalHarmonicsL2();
        for (int channel = 0; channel < 3; channel++)
        {
            for (int index = 0; index < 9; index++)
            {
                probe[channel, index] = harmonics.coefficients[9 * channel + index];
            }
        }
        return probe;
    }

    static Material Sky(string map, string name)
    {
        TextureImporter importer = AssetImporter.GetAtPath(map) as TextureImporter;
        if (importer == null)
        {
            throw new ArgumentException("expected the map " + map);
        }
        importer.textureShape = TextureImporterShape.Texture2D;
        importer.npotScale = TextureImporterNPOTScale.None;
        importer.textureCompression = TextureImporterCompression.Uncompressed;
        importer.maxTextureSize = 8192;
        importer.wrapModeU = TextureWrapMode.Repeat;
        importer.wrapModeV = TextureWrapMode.Clamp;
        importer.SaveAndReimport();

        Material sky = new Material(Shader.Find("Skybox/Panoramic"));
        sky.name = name;
        sky.SetTexture("_MainTex", AssetDatabase.LoadAssetAtPath<Texture2D>(map));
        sky.SetFloat("_Mapping", 1f); // latitude and longitude
        sky.EnableKeyword("_MAPPING_LATITUDE_LONGITUDE_LAYOUT");
        sky.SetFloat("_ImageType", 0f); // all around
        sky.SetFloat("_Rotation", 0f);
        // The shader multiplies by the tint, gray by default, and by a constant that nearly undoes it.
        Color tint = new Color(0.5f, 0.5f, 0.5f, 0.5f);
        sky.SetColor("_Tint", tint);
        bool linear = QualitySettings.activeColorSpace == ColorSpace.Linear;
        sky.SetFloat("_Exposure", linear ? 1f / (tint.linear.r * 4.59479380f) : 1f);
        AssetDatabase.CreateAsset(sky, AssetDatabase.GenerateUniqueAssetPath(Path.ChangeExtension(map, ".mat")));
        return sky;
    }

    static void Directional(NamedLight entry, Transform parent)
    {
        GameObject item = new GameObject(entry.name);
        item.transform.SetParent(parent, false);
        Vector3 towards = new Vector3(entry.direction[0], entry.direction[1], entry.direction[2]);
        item.transform.rotation = Quaternion.LookRotation(-towards);

        // Intensity 1 shows a white matte surface as 1: irradiance over pi.
        Color shown = new Color(entry.irradiance[0], entry.irradiance[1], entry.irradiance[2]) / Mathf.PI;
        Light light = item.AddComponent<Light>();
        light.type = LightType.Directional;
        light.shadows = LightShadows.Soft;
        light.useColorTemperature = false;
        if (GraphicsSettings.lightsUseLinearIntensity)
        {
            float peak = Mathf.Max(shown.maxColorComponent, 1e-8f);
            light.color = (shown / peak).gamma;
            light.intensity = peak;
        }
        else
        {
            // Here colour times intensity is taken as a gamma value as a whole.
            Color encoded = shown.gamma;
            float peak = Mathf.Max(encoded.maxColorComponent, 1e-8f);
            light.color = encoded / peak;
            light.intensity = peak;
        }
        light.enabled = entry.enabled;
    }
}
